#include "jaculus/components/motor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace jaculus::components {
namespace {

// Table I of Norby et al. 2021 with a lossy gear.
model::PlanarMotor tail_motor() {
  model::PlanarMotor m;
  m.torque_constant = 0.0954;
  m.resistance = 0.186;
  m.saturation_linear = 8.93;
  m.saturation_cubic = 0.539;
  m.voltage = 16.0;
  m.gear = 4.0;
  m.efficiency = 0.8;
  return m;
}

double central(const auto& f, double x, double h) {
  return (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h);
}

TEST(Motor, CurrentFollowsTheCubicBehindTheGear) {
  const model::PlanarMotor m = tail_motor();
  // 3 N m at the motor is 9.6 N m at the joint: 0.539 * 27 + 8.93 * 3 = 41.343 A.
  EXPECT_NEAR(motor_current(m, 9.6), 41.343, 1e-12);
  EXPECT_DOUBLE_EQ(motor_current(m, -9.6), -motor_current(m, 9.6));
}

TEST(Motor, VoltageIsResistiveDropPlusBackEmf) {
  const model::PlanarMotor m = tail_motor();
  EXPECT_NEAR(motor_voltage(m, 9.6, 10.0).value, 0.186 * 41.343 + 0.0954 * 40.0, 1e-12);
}

TEST(Motor, DerivativesAgreeWithDifferences) {
  const model::PlanarMotor m = tail_motor();
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> torque(-12.0, 12.0), rate(-40.0, 40.0);
  const double h = 1e-3;
  for (int k = 0; k < 200; ++k) {
    const double t = torque(rng), w = rate(rng);
    const MotorCurrent i = motor_current_derivatives(m, t);
    EXPECT_DOUBLE_EQ(i.value, motor_current(m, t));
    EXPECT_NEAR(i.d_torque, central([&](double x) { return motor_current(m, x); }, t, h), 1e-9);
    EXPECT_NEAR(i.d_torque2,
                central([&](double x) { return motor_current_derivatives(m, x).d_torque; }, t, h),
                1e-9);
    const MotorVoltage v = motor_voltage(m, t, w);
    EXPECT_NEAR(v.d_torque, central([&](double x) { return motor_voltage(m, x, w).value; }, t, h),
                1e-9);
    EXPECT_NEAR(v.d_rate, central([&](double x) { return motor_voltage(m, t, x).value; }, w, h),
                1e-9);
    EXPECT_NEAR(v.d_torque2,
                central([&](double x) { return motor_voltage(m, x, w).d_torque; }, t, h), 1e-9);
    const MotorPower p = motor_power(m, t, w);
    EXPECT_NEAR(p.value, v.value * i.value, 1e-12 * std::abs(p.value));
    EXPECT_NEAR(p.d_torque, central([&](double x) { return motor_power(m, x, w).value; }, t, h),
                1e-7);
    EXPECT_NEAR(p.d_rate, central([&](double x) { return motor_power(m, t, x).value; }, w, h),
                1e-7);
    EXPECT_NEAR(p.d_torque2, central([&](double x) { return motor_power(m, x, w).d_torque; }, t, h),
                1e-7);
    EXPECT_NEAR(p.d_torque_rate,
                central([&](double x) { return motor_power(m, x, w).d_rate; }, t, h), 1e-7);
  }
}

TEST(Motor, FrictionOpposesTheRateAndItsDerivativesAgreeWithDifferences) {
  model::PlanarMotor m = tail_motor();
  EXPECT_FALSE(rubs(m));
  m.viscous_friction = 0.03;
  m.dry_friction = 0.2;
  EXPECT_TRUE(rubs(m));
  // far above 0.1 rad/s dry friction is whole
  EXPECT_NEAR(motor_friction(m, 10.0).value, -(0.2 + 0.3), 1e-12);
  EXPECT_NEAR(motor_friction(m, -10.0).value, 0.2 + 0.3, 1e-12);
  EXPECT_EQ(motor_friction(m, 0.0).value, 0.0);
  // a motor that makes up for it pushes the way the joint turns
  EXPECT_NEAR(against_dry_friction(m, 10.0).value, 0.2, 1e-12);

  const double h = 1e-4;
  for (const double w : {-2.0, -0.13, -0.02, 0.0, 0.05, 0.31, 4.0}) {
    const MotorFriction f = motor_friction(m, w);
    const auto value = [&](double x) { return motor_friction(m, x).value; };
    const auto slope = [&](double x) { return motor_friction(m, x).d_rate; };
    EXPECT_NEAR(f.d_rate, central(value, w, h), 1e-9) << w;
    EXPECT_NEAR(f.d_rate2, central(slope, w, h), 1e-7) << w;
    // d/dw tanh = (1 - tanh^2)/s: the slope follows from the value
    const double dry = -(f.value + 0.03 * w) / 0.2;
    EXPECT_NEAR(f.d_rate, -(0.03 + 0.2 * (1.0 - dry * dry) / 0.1), 1e-12) << w;
  }
}

TEST(Motor, SaturationIsInvertedToTheLastDigits) {
  for (double cubic : {0.0, 1e-12, 1e-3, 0.539, 80.0}) {
    for (double t : {-30.0, -3.0, -1e-6, 0.0, 1e-9, 0.4, 7.0}) {
      const double i = 8.93 * t + cubic * t * t * t;
      EXPECT_NEAR(saturated_torque(8.93, cubic, i), t, 4e-15 * std::abs(t)) << cubic << " " << t;
    }
  }
  EXPECT_NEAR(saturated_torque(0.0, 2.0, 54.0), 3.0, 1e-14);
}

TEST(Motor, TorqueAtVoltageInvertsVoltage) {
  const model::PlanarMotor m = tail_motor();
  for (double t : {-20.0, -1.0, 0.3, 9.0}) {
    for (double w : {-25.0, 0.0, 30.0}) {
      EXPECT_NEAR(joint_torque_at_voltage(m, motor_voltage(m, t, w).value, w), t,
                  1e-12 * std::abs(t) + 1e-13);
    }
  }
}

TEST(Motor, TheTighterLimitBindsAndIsNamed) {
  model::PlanarMotor m = tail_motor();
  EXPECT_EQ(largest_joint_torque(m).limit, MotorLimit::none);
  EXPECT_TRUE(std::isinf(largest_joint_torque(m).value));
  m.torque_limit = 3.0;
  EXPECT_EQ(largest_joint_torque(m).limit, MotorLimit::torque);
  EXPECT_NEAR(largest_joint_torque(m).value, 9.6, 1e-14);
  m.current_limit = 8.93 + 0.539;  // 1 N m before the gear
  EXPECT_EQ(largest_joint_torque(m).limit, MotorLimit::current);
  EXPECT_NEAR(largest_joint_torque(m).value, 3.2, 1e-14);
  const LimitedTorque held = limited_joint_torque_at_voltage(m, -16.0, 0.0);
  EXPECT_EQ(held.limit, MotorLimit::current);
  EXPECT_NEAR(held.value, -3.2, 1e-14);
  const LimitedTorque free = limited_joint_torque_at_voltage(m, 1.0, 0.0);
  EXPECT_EQ(free.limit, MotorLimit::none);
  EXPECT_NEAR(motor_voltage(m, free.value, 0.0).value, 1.0, 1e-13);
}

}  // namespace
}  // namespace jaculus::components
