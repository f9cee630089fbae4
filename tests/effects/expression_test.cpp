// Formulas: what they compute, which names they use, and where faults stand.

#include "effects/user/expression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "jaculus/core/types.h"

namespace jaculus::effects {
namespace {

double value_of(const std::string& text, double x = 0.0) {
  double at = x, other = 2.0;
  return Expression(text, {{"x", &at}, {"elbow.q", &other}}).value();
}

TEST(Expression, ComputesWhatIsWritten) {
  EXPECT_EQ(value_of("1 + 2*3^2"), 19.0);
  EXPECT_EQ(value_of("-x^2", 3.0), -9.0);
  EXPECT_EQ(value_of("2^3^2"), 512.0);
  EXPECT_EQ(value_of("1e-3*x + .5", 2.0), 0.502);
  EXPECT_EQ(value_of("x > 1 && x < 3 ? 7 : 8", 2.0), 7.0);
  EXPECT_EQ(value_of("x == 2 || x != x ? 7 : 8", 3.0), 8.0);
  EXPECT_EQ(value_of("elbow.q*x", 4.0), 8.0);
  EXPECT_EQ(value_of("cos(pi)"), -1.0);
  EXPECT_EQ(value_of("sign(x)*floor(abs(x))", -2.5), -2.0);
  EXPECT_EQ(value_of("mod(x, 3)", -1.0), 2.0);
  EXPECT_EQ(value_of("min(x, 3) + max(x, 3)", 5.0), 8.0);
  EXPECT_EQ(value_of("hypot(3, 4) + sqrt(9) + ln(1) + exp(0)"), 9.0);
  EXPECT_EQ(value_of("atan2(1, 1)"), std::numbers::pi / 4.0);
  EXPECT_EQ(value_of("tanh(x)", 0.3), std::tanh(0.3));
}

TEST(Expression, FollowsItsSymbols) {
  double x = 1.0;
  const Expression twice("2*x", {{"x", &x}});
  EXPECT_EQ(twice.value(), 2.0);
  x = 5.0;
  EXPECT_EQ(twice.value(), 10.0);
}

TEST(Expression, NamesAreFoundWithTheirColumns) {
  const std::vector<UsedName> names = names_in("2e3*q + sin(elbow.q) - q*pi - x_1e2");
  ASSERT_EQ(names.size(), 3u);
  EXPECT_EQ(names[0].name, "q");
  EXPECT_EQ(names[0].column, 5);
  EXPECT_EQ(names[1].name, "elbow.q");
  EXPECT_EQ(names[2].name, "x_1e2");
  EXPECT_EQ(names[2].column, 31);
}

int column_of(const std::string& text) {
  try {
    (void)value_of(text);
  } catch (const ExpressionError& error) {
    return error.column;
  }
  ADD_FAILURE() << text << " was read";
  return 0;
}

TEST(Expression, FaultsHaveAColumn) {
  EXPECT_EQ(column_of("x + * 2"), 5);
  EXPECT_EQ(column_of("x + y"), 5);
  EXPECT_EQ(column_of("sin(x"), 6);  // past the end
  EXPECT_EQ(column_of("x = 2"), 3);
  EXPECT_EQ(column_of("x 2"), 3);
  EXPECT_EQ(column_of("x; 2"), 2);
  EXPECT_EQ(column_of("\"x\""), 1);
  EXPECT_GT(column_of("sin(x, x)"), 0);
  EXPECT_GT(column_of("x, x"), 0);
  EXPECT_GT(column_of("log(x)"), 0);  // of which base?
}

}  // namespace
}  // namespace jaculus::effects
