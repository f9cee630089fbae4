// Logged values beside what the robot's motors and joints can reach.

#include "jaculus/simulation/log_limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

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
  // One bad angle, which spoils two rates.
  trajectory::Dataset spiked = swing(1.0, 1.0, 1.0);
  spiked.trials[0].streams[0].values(0, 50) = 40.0;
  EXPECT_TRUE(values_out_of_reach(spiked, pendulum()).empty());
  // A torque that reads half as much again is a scale, not another unit.
  EXPECT_TRUE(values_out_of_reach(swing(1.0, 1.0, 1.5), pendulum()).empty());
}

TEST(LogLimits, NameTorquesThatNoMotorGives) {
  const auto found = values_out_of_reach(swing(1.0, 1.0, 100.0), pendulum());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].text.find("N m; the motor gives 1.2 N m at most"), std::string::npos);
  EXPECT_TRUE(found[0].impossible);
}

TEST(LogLimits, NameAnglesInDegreesEvenWhereTheirRatesAreToo) {
  const double degrees = 180.0 / M_PI;
  const auto found = values_out_of_reach(swing(degrees, degrees, 1.0), pendulum());
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NE(found[0].text.find("joints.swing moves at"), std::string::npos) << found[0].text;
  EXPECT_NE(found[1].text.find("without load the motor drives it at 40 rad/s at most"),
            std::string::npos)
      << found[1].text;
}

TEST(LogLimits, CallNothingImpossibleThatOnlyStatedLimitsHold) {
  // A range without a stop, and the speed that plans of an ideal motor keep below.
  model::PlanarModel ideal = pendulum();
  ideal.motors[0] = model::PlanarMotor{.joint = "swing", .voltage = kInfinity, .speed_limit = 1.0};
  ideal.coordinates[0].range = {-0.1, 0.1};
  const auto limited = values_out_of_reach(swing(1.0, 1.0, 1.0), ideal);
  ASSERT_EQ(limited.size(), 2u);
  for (const OutOfReach& own : limited) EXPECT_FALSE(own.impossible) << own.text;

  ideal.motors[0].speed_limit = kInfinity;
  const auto ranged = values_out_of_reach(swing(1.0, 1.0, 1.0), ideal);
  ASSERT_EQ(ranged.size(), 1u);
  EXPECT_EQ(ranged[0].text, "joints.swing spans 2 rad; the joint's range is 0.2 rad");
  EXPECT_FALSE(ranged[0].impossible);
}

TEST(LogLimits, KnowADutyAVoltageAndACurrent) {
  trajectory::Dataset dataset = swing(1.0, 1.0, 50.0);
  trajectory::Stream& stream = dataset.trials[0].streams[0];
  for (const auto& [quantity, unit, says] :
       {std::tuple("duty", "-", "; a duty is 1 at most"),
        std::tuple("voltage", "V", " V; the bus has 24 V at most"),
        std::tuple("current", "A", " A; the motor takes 2 A at most")}) {
    stream.channels[2] = std::string("swing_") + quantity;
    stream.units[2] = unit;
    const auto found = values_out_of_reach(dataset, pendulum());
    ASSERT_EQ(found.size(), 1u) << quantity;
    EXPECT_NE(found[0].text.find(says), std::string::npos) << found[0].text;
  }
}

TEST(LogLimits, SayNothingOfAMotorWhoseLimitsAreNotStated) {
  model::PlanarModel ideal = pendulum();
  ideal.motors[0] = model::PlanarMotor{.joint = "swing", .voltage = kInfinity};
  EXPECT_TRUE(values_out_of_reach(swing(1.0, 1.0, 1e6), ideal).empty());
}

}  // namespace
}  // namespace jaculus::simulation
