#include "jaculus/studies/comparison.h"

#include <gtest/gtest.h>

#include "support/input_error.h"
#include "support/sample_comparison.h"

namespace jaculus::studies {
namespace {

using test::holds;

TEST(Comparison, JsonAndCsvAgree) {
  const std::vector<ComparisonRow> rows = test::two_rows();
  const auto json = comparison_json(rows);
  EXPECT_EQ(json["problems"].size(), 2u);
  EXPECT_EQ(json["problems"][1]["name"], "leap");
  EXPECT_NEAR(json["problems"][1]["gain_over_tailless"]["average_acceleration"].get<double>(), 0.1,
              1e-12);
  EXPECT_EQ(json["reference"]["leap"]["average_acceleration_m_s2"], 6.803);
  const std::string csv = comparison_csv(rows);
  const auto commas = [](const std::string& line) {
    return std::count(line.begin(), line.end(), ',');
  };
  const std::size_t first = csv.find('\n');
  const std::size_t second = csv.find('\n', first + 1);
  EXPECT_EQ(commas(csv.substr(0, first)), commas(csv.substr(first + 1, second - first - 1)));
  EXPECT_TRUE(holds(csv, "tailless,none,optimal,6,"));
}

}  // namespace
}  // namespace jaculus::studies
