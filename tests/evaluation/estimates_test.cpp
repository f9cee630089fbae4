// Intervals beside published ones and those of closed forms.

#include "evaluation/estimates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace jaculus::evaluation {
namespace {

TEST(Estimates, WilsonAgainstItsTable) {
  // 0 of 60: z^2/(60 + z^2); 5 of 10: published (0.2366, 0.7634).
  EXPECT_NEAR(evaluation::proportion(0, 60).ci95.upper, 3.8414588 / 63.8414588, 1e-7);
  EXPECT_NEAR(evaluation::proportion(0, 60).ci95.lower, 0.0, 1e-15);
  EXPECT_NEAR(evaluation::proportion(5, 10).ci95.lower, 0.2366, 5e-5);
  EXPECT_NEAR(evaluation::proportion(5, 10).ci95.upper, 0.7634, 5e-5);
  EXPECT_EQ(evaluation::proportion(0, 0).count, 0);
}

TEST(Estimates, MedianByOrderStatistics) {
  std::vector<double> values;
  for (int i = 1; i <= 20; ++i) values.push_back(i);
  const ScoreEstimate e = evaluation::median(values);
  EXPECT_EQ(e.value, 10.5);
  EXPECT_EQ(e.ci95.lower, 6.0);  // binomial(20, 1/2): 6 and 15 cover 95.9 %
  EXPECT_EQ(e.ci95.upper, 15.0);
  EXPECT_TRUE(std::isinf(evaluation::median({1.0, 2.0, 3.0}).ci95.upper));
}

}  // namespace
}  // namespace jaculus::evaluation
