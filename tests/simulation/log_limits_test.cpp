// Logged values beside what the robot's motors and joints can reach.

#include "jaculus/simulation/log_limits.h"

#include <gtest/gtest.h>

#include <cmath>

namespace jaculus::simulation {
namespace {

/// A joint with a motor of 24 V: without load 40 rad/s, 1.2 N m at the 2 A of its driver.
model::PlanarModel pendulum() {
  model::PlanarMotor motor;
  motor.joint = "swing";
  motor.torque_constant = 0.06;
  motor.resistance = 1.0;
  motor.saturation_linear = 1.0 / 0.06;
  motor.voltage = 24.0;
  motor.gear = 10.0;
  motor.current_limit = 2.0;
  model::PlanarModel model;
  model.motors = {motor};
  model.coordinates = {{"swing", true, {}}};
  return model;
}

/// A swing of 1 Hz and 1 rad at 200 Hz under 1 N m, each channel times a factor.
trajectory::Dataset swing(double by_angle, double by_rate, double by_torque) {
  constexpr int kSamples = 400;
  trajectory::Stream stream{"joints",
                            200.0,
                            Vector::LinSpaced(kSamples, 0.0, (kSamples - 1) / 200.0),
                            {"swing", "swing_velocity", "swing_torque", "other"},
                            {"rad", "rad/s", "N m", "rad"},
                            Matrix::Constant(4, kSamples, 1e9)};
  for (int k = 0; k < kSamples; ++k) {
    const double phase = 2.0 * M_PI * stream.time[k];
    stream.values(0, k) = by_angle * std::sin(phase);
    stream.values(1, k) = by_rate * 2.0 * M_PI * std::cos(phase);
    stream.values(2, k) = by_torque * std::sin(phase);
  }
  stream.values(0, 100) = kNaN;
  stream.values(2, 200) = 1e6;  // one bad packet
  trajectory::Dataset dataset;
  dataset.trials = {{"trial_01", {stream}}};
  return dataset;
}

TEST(LogLimits, FindNothingInALogThatTheRobotCanMake) {
  EXPECT_TRUE(values_out_of_reach(swing(1.0, 1.0, 1.0), pendulum()).empty());
  // A torque that reads half as much again is a scale, not another unit.
  EXPECT_TRUE(values_out_of_reach(swing(1.0, 1.0, 1.5), pendulum()).empty());
}

TEST(LogLimits, NameTorquesThatNoMotorGives) {
  const auto found = values_out_of_reach(swing(1.0, 1.0, 100.0), pendulum());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], "joints.swing_torque reaches 100 N m; the motor gives 1.2 N m at most");
}

TEST(LogLimits, NameAnglesInDegreesEvenWhereTheirRatesAreToo) {
  const double degrees = 180.0 / M_PI;
  const auto found = values_out_of_reach(swing(degrees, degrees, 1.0), pendulum());
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NE(found[0].find("joints.swing moves at"), std::string::npos) << found[0];
  EXPECT_EQ(found[1],
            "joints.swing_velocity reaches 360 rad/s; without load the motor turns at 40 rad/s "
            "at most");

  // A joint with a range tells by itself.
  model::PlanarModel ranged = pendulum();
  ranged.coordinates[0].range = {-1.5, 1.5};
  const auto spans = values_out_of_reach(swing(degrees, 1.0, 1.0), ranged);
  ASSERT_EQ(spans.size(), 1u);
  EXPECT_EQ(spans[0], "joints.swing spans 115 rad; the joint's range is 3 rad");
}

TEST(LogLimits, SayNothingOfAMotorWhoseLimitsAreNotStated) {
  model::PlanarModel ideal = pendulum();
  ideal.motors[0] = model::PlanarMotor{.joint = "swing", .voltage = kInfinity};
  EXPECT_TRUE(values_out_of_reach(swing(1.0, 1.0, 1e6), ideal).empty());
}

}  // namespace
}  // namespace jaculus::simulation
