// Fits near another, by slopes that are known.

#include "diagnosis/selection/known_slopes.h"

#include <gtest/gtest.h>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/fit.h"
#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kOfATolerance = 0.05;  ///< by which a deviation of it moves what `first` moves

/// The toy, of which `first` and a tolerance do the same and the second channel bends with both.
std::shared_ptr<Problem> tolerant_toy(double first) {
  auto problem = test::toy_problem(test::toy_truth(first, 0.0));
  const int tolerance = count_of(problem->hypotheses.parameters);
  problem->hypotheses.parameters.push_back(
      {"tolerance", "shape", "deviations", 0.0, 1.0, {-2.0, 2.0}});
  problem->hypotheses.tolerances = {tolerance};
  problem->forward = [tolerance](int, int, const Vector& p) {
    Vector all = p.head(4);
    all[0] += kOfATolerance * p[tolerance];
    return test::toy_prediction(all);
  };
  return problem;
}

/// All parameters without `first`: as another fit has them, and as the one with it expects them.
struct Without {
  Vector fitted, expected;
};
Without without_first(double first) {
  const auto problem = tolerant_toy(first);
  const Hypotheses& hypotheses = problem->hypotheses;
  const Vector nominal = hypotheses.nominal();
  const Comparison comparison = comparison_about(*problem, estimate_noise(*problem, nominal));
  const auto fitted = [&](const std::vector<int>& members) {
    const Fit fit =
        fit_model(*problem, comparison.whitening, hypotheses.freed_by(members), {nominal});
    EXPECT_TRUE(fit.valid) << fit.message;
    return fit;
  };
  return {fitted({1}).p, optimum_without(*problem, fitted({0, 1}), {0})};
}

TEST(OptimumWithout, IsThatOfTheSmallerModelWhereAllIsLinear) {
  const Without small = without_first(0.08);
  EXPECT_GT(small.fitted[4], 1.5);  // the tolerance does what the effect did
  EXPECT_NEAR(small.expected[4], small.fitted[4], 0.02);
  EXPECT_NEAR(small.expected[1], small.fitted[1], 1e-4);
  EXPECT_EQ(small.expected[0], 0.0);
}

TEST(OptimumWithout, EndsWithTheTolerance) { EXPECT_EQ(without_first(0.16).expected[4], 2.0); }

}  // namespace
}  // namespace jaculus::diagnosis
