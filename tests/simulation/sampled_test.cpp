// What samples hold beside the motion: the same numbers, or none, whichever is asked for.

#include <gtest/gtest.h>

#include "simulation/support.h"

namespace jaculus::simulation {
namespace {

using namespace test;

constexpr double kLoop = 100.0;  // [Hz], slower than the samples, so that these lie within steps

/// A link whose motor's torque follows its angle and rate, from rest 0.5 rad away.
Simulation swing(Sampled sampled) {
  model::PlanarModel model = test_support::on_fixed_base(
      {link("arm", 0, Vec2::Zero(), 1.0, Vec2(0.3, 0.0), 0.01)}, {"arm"});
  model::PlanarMotor motor;
  motor.joint = "arm";
  motor.body = 1;
  motor.torque_constant = 0.1;
  motor.saturation_linear = 10.0;  // [A/(N m)], its inverse
  motor.resistance = 0.2;
  motor.voltage = 12.0;
  model.motors = {motor};

  Controller c;
  c.rate_hz = kLoop;
  c.quantity = trajectory::Quantity::voltage;
  c.kp = Vector::Constant(1, 6.0);
  c.kd = Vector::Constant(1, 0.2);
  c.reference.motors = {"arm"};
  c.reference.time = (Vector(2) << 0.0, 0.3).finished();
  c.reference.duration = 0.3;
  c.reference.position = c.reference.velocity = c.reference.feedforward = Matrix::Zero(1, 2);
  SimulationOptions options = options_for(0.3, 97);
  options.sampled = sampled;
  return simulate(plant_of(model, 0.0), c, start_at({0.5}, {0}), options);
}

TEST(Sampled, MotorsByTheirOwnLawAreThoseOfTheWholeEquations) {
  const Simulation all = swing(Sampled::all), motors = swing(Sampled::motors);
  ASSERT_EQ(all.status, SimulationStatus::done) << all.message;
  EXPECT_EQ(motors.q, all.q);
  EXPECT_EQ(motors.torque, all.torque);
  EXPECT_EQ(motors.current, all.current);
  EXPECT_EQ(motors.voltage, all.voltage);
  EXPECT_EQ(motors.bus_voltage, all.bus_voltage);
  EXPECT_GT(all.torque.cwiseAbs().maxCoeff(), 0.1);
  EXPECT_LT(motors.evaluations, all.evaluations);
}

TEST(Sampled, TheMotionAloneIsTheSame) {
  const Simulation all = swing(Sampled::all), motion = swing(Sampled::motion);
  EXPECT_EQ(motion.q, all.q);
  EXPECT_EQ(motion.motor_velocity, all.motor_velocity);
  EXPECT_TRUE(motion.torque.array().isNaN().all());
  EXPECT_TRUE(motion.bus_voltage.array().isNaN().all());
}

TEST(Sampled, ForcesOfTheFloorAreLeftOutWhereMotorsAreAskedFor) {
  const Plant standing =
      plant_of(body_with_feet(2.0, 0.05, {Vec2(-0.2, -0.1), Vec2(0.2, -0.1)}), 0.8);
  SimulationOptions options = options_for(0.05);
  const auto stand = [&](Sampled sampled) {
    options.sampled = sampled;
    return simulate(standing, no_controller(), start_at({0, 0.1, 0}, {0, 0, 0}), options);
  };
  const Simulation all = stand(Sampled::all);
  for (Eigen::Index k = 0; k < all.time.size(); ++k)
    EXPECT_NEAR(all.force(1, k) + all.force(3, k), 2.0 * 9.81, 0.01) << k;
  EXPECT_TRUE(stand(Sampled::motors).force.array().isNaN().all());
}

}  // namespace
}  // namespace jaculus::simulation
