#include "jaculus/components/motor.h"

#include <cassert>
#include <cmath>

namespace jaculus::components {

double motor_current(const model::PlanarMotor& motor, double joint_torque) {
  const double t = joint_torque / (motor.gear * motor.efficiency);
  return t * (motor.saturation_linear + motor.saturation_cubic * t * t);
}

MotorCurrent motor_current_derivatives(const model::PlanarMotor& motor, double joint_torque) {
  const double scale = 1.0 / (motor.gear * motor.efficiency);
  const double t = joint_torque * scale;
  const double a = motor.saturation_linear;
  const double c = motor.saturation_cubic;
  return {t * (a + c * t * t), scale * (a + 3.0 * c * t * t), scale * scale * 6.0 * c * t};
}

MotorVoltage motor_voltage(const model::PlanarMotor& motor, double joint_torque,
                           double joint_rate) {
  const MotorCurrent i = motor_current_derivatives(motor, joint_torque);
  const double back_emf = motor.torque_constant * motor.gear;
  const double r = motor.resistance;
  return {r * i.value + back_emf * joint_rate, r * i.d_torque, back_emf, r * i.d_torque2};
}

bool rubs(const model::PlanarMotor& motor) {
  return motor.viscous_friction != 0.0 || motor.dry_friction != 0.0;
}

MotorFriction motor_friction(const model::PlanarMotor& motor, double joint_rate) {
  const MotorFriction dry = against_dry_friction(motor, joint_rate);
  const double b = motor.viscous_friction;
  return {-(b * joint_rate + dry.value), -(b + dry.d_rate), -dry.d_rate2};
}

MotorFriction against_dry_friction(const model::PlanarMotor& motor, double joint_rate) {
  constexpr double s = kDryFrictionSmoothing;
  const double t = std::tanh(joint_rate / s);
  const double slope = motor.dry_friction / s * (1.0 - t * t);
  return {motor.dry_friction * t, slope, -2.0 * slope * t / s};
}

MotorPower motor_power(const model::PlanarMotor& motor, double joint_torque, double joint_rate) {
  const MotorCurrent i = motor_current_derivatives(motor, joint_torque);
  const MotorVoltage v = motor_voltage(motor, joint_torque, joint_rate);
  return {v.value * i.value, v.d_torque * i.value + v.value * i.d_torque, v.d_rate * i.value,
          v.d_torque2 * i.value + 2.0 * v.d_torque * i.d_torque + v.value * i.d_torque2,
          v.d_rate * i.d_torque};
}

namespace {

// q up to which the start below was fitted: of its form the one of least relative error there.
constexpr double kFarSaturated = 8.0;

/// With t = 2 p sinh(y), p = sqrt(a/(3c)), the cubic turns into sinh(3y) = z = 3 i/(2 a p), and
/// exp(y) = w = (z + sqrt(z^2 + 1))^(1/3) (Cardano's formula). A Newton step takes it to the last
/// digits.
double deeply_saturated_torque(double linear, double cubic, double current) {
  const double p = std::sqrt(linear / (3.0 * cubic));
  const double z = 1.5 * std::abs(current) / (linear * p);
  const double w = std::cbrt(z + std::hypot(z, 1.0));
  if (std::isinf(w)) return std::cbrt(current / cubic);
  const double t = std::copysign(p * (w - 1.0 / w), current), t2 = t * t;
  return t - (t * (linear + cubic * t2) - current) / (linear + 3.0 * cubic * t2);
}

}  // namespace

MagneticSaturation::MagneticSaturation(double linear, double cubic)
    : linear_(linear), cubic_(cubic) {
  assert(linear >= 0.0 && cubic >= 0.0 && linear + cubic > 0.0);
  if (linear == 0.0 || cubic == 0.0) return;
  corner_torque_ = std::sqrt(linear / cubic);
  per_current_ = 1.0 / (linear * corner_torque_);
}

double MagneticSaturation::torque(double current) const {
  if (cubic_ == 0.0) return current / linear_;
  if (linear_ == 0.0) return std::cbrt(current / cubic_);
  // With t = p s, p = sqrt(a/c), the cubic is s + s^3 = q = |i|/(a p).
  const double q = per_current_ * std::abs(current);
  if (!(q <= kFarSaturated)) return deeply_saturated_torque(linear_, cubic_, current);
  // Within 0.15 % of the root; a step of Halley's leaves 2e-9, one of Newton's the last digits.
  double s =
      q * (1.0 + q * (2.168 + 0.65989 * q)) / (1.0 + q * (2.1095 + q * (2.2984 + 0.19469 * q)));
  const double f = s * (1.0 + s * s) - q, slope = 1.0 + 3.0 * s * s;
  s -= f * slope / (slope * slope - 3.0 * f * s);
  s -= (s * (1.0 + s * s) - q) / (1.0 + 3.0 * s * s);
  return std::copysign(corner_torque_ * s, current);
}

double saturated_torque(double linear, double cubic, double current) {
  return MagneticSaturation(linear, cubic).torque(current);
}

double joint_torque_at_voltage(const model::PlanarMotor& motor, double voltage, double joint_rate) {
  assert(motor.resistance > 0.0);
  const double current =
      (voltage - motor.torque_constant * motor.gear * joint_rate) / motor.resistance;
  return motor.gear * motor.efficiency *
         saturated_torque(motor.saturation_linear, motor.saturation_cubic, current);
}

LimitedTorque largest_joint_torque(const model::PlanarMotor& motor) {
  const double ratio = motor.gear * motor.efficiency;
  double by_current = kInfinity;
  if (std::isfinite(motor.current_limit)) {
    by_current =
        saturated_torque(motor.saturation_linear, motor.saturation_cubic, motor.current_limit);
  }
  if (std::isinf(by_current) && std::isinf(motor.torque_limit))
    return {kInfinity, MotorLimit::none};
  if (by_current < motor.torque_limit) return {ratio * by_current, MotorLimit::current};
  return {ratio * motor.torque_limit, MotorLimit::torque};
}

LimitedTorque limited_joint_torque_at_voltage(const model::PlanarMotor& motor, double voltage,
                                              double joint_rate) {
  const double torque = joint_torque_at_voltage(motor, voltage, joint_rate);
  const LimitedTorque largest = largest_joint_torque(motor);
  if (std::abs(torque) <= largest.value) return {torque, MotorLimit::none};
  return {std::copysign(largest.value, torque), largest.limit};
}

}  // namespace jaculus::components
