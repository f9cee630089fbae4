#include "simulation/experiment/channel_values.h"

#include <gtest/gtest.h>

#include <cmath>

namespace jaculus::simulation {
namespace {

constexpr double kStep = 1e-3, kTime = 2e-3;  // s

TEST(LowPass, LagsBehindARampByItsTime) {
  const Eigen::RowVectorXd ramp = Eigen::RowVectorXd::LinSpaced(41, 0.0, 0.4);
  const Eigen::RowVectorXd passed = low_passed(ramp, kStep, kTime);
  const double slope = 0.4 / (40 * kStep);
  for (Eigen::Index k = 0; k < ramp.size(); ++k) {
    const double t = static_cast<double>(k) * kStep;
    EXPECT_NEAR(passed[k], slope * (t - kTime * (1.0 - std::exp(-t / kTime))), 1e-12);
  }
}

TEST(LowPass, SettlesFromAJumpByItsTime) {
  Eigen::RowVectorXd jump = Eigen::RowVectorXd::Ones(21);
  jump[0] = 0.0;
  const Eigen::RowVectorXd passed = low_passed(jump, kStep, kTime);
  // after the sample within which it rises
  for (Eigen::Index k = 2; k < jump.size(); ++k)
    EXPECT_NEAR((1.0 - passed[k]) / (1.0 - passed[k - 1]), std::exp(-kStep / kTime), 1e-12);
}

TEST(LowPass, OfNoTimeIsTheValueItselfWithTheSlopeOfADelay) {
  Eigen::RowVectorXd values(5);
  values << 0.0, 1.0, -2.0, 0.5, 3.0;
  EXPECT_EQ(low_passed(values, kStep, 0.0), values);
  const double little = 1e-6;
  const Eigen::RowVectorXd passed = low_passed(values, kStep, little);
  for (Eigen::Index k = 1; k < values.size(); ++k)
    EXPECT_NEAR((passed[k] - values[k]) / little, -(values[k] - values[k - 1]) / kStep, 1e-6);
}

}  // namespace
}  // namespace jaculus::simulation
