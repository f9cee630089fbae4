#pragma once
// Brushed-equivalent electric motor behind a gear: current, voltage and power as functions of joint
// torque and rate.
//
//   motor torque    tau_m = tau / (G eta)                 tau: joint torque [N m]
//   current         i     = a tau_m + c tau_m^3           a: saturation_linear, c: saturation_cubic
//   voltage         V     = R i + k_t G omega             omega: joint rate [rad/s]
//   electric power  P     = V i
//
// Source: Norby et al. 2021, equations 5 to 7 (magnetic saturation as an odd cubic; V there is the
// battery's). The gear's efficiency eta is not in these equations; it is the loss that a plan
// allows for.
//
// Friction of motor, gear and bearing at the joint, of one of a pair:
//   tau_f = -(b omega + c tanh(omega/s))                  b: viscous_friction, c: dry_friction,
// s = 0.1 rad/s, as the friction of simulation/plant.h has it: dry friction as far as one can
// differentiate it. Below s a joint creeps that a real one would hold.
//
// A plan lets the motor make up for the dry part, as controllers do that know it: its input u is
// the torque beside that, the motor's torque u + c tanh(omega/s). On a light link the dry part is
// the stiffest thing in the motion (0.5 N m on a shank of 4e-4 kg m^2: 0.1 rad/s within 0.1 ms),
// which no mesh resolves; as a part of the torque it is a function of the state like any other.
//
// Limits of validity: winding inductance, rotor inertia (part of the joint's inertia) are not
// here. Efficiency is applied as tau_m = tau / (G eta) in both directions of power flow,
// which is how limits are usually set: where the joint drives the motor a real gear would give
// tau_m = tau eta / G instead, so braking currents are overstated by up to 1/eta^2. With eta = 1
// there is no difference.

#include "jaculus/model/planar.h"

namespace jaculus::components {

/// Current [A] with its derivatives by joint torque; it does not depend on the rate.
struct MotorCurrent {
  double value = 0.0;      ///< [A]
  double d_torque = 0.0;   ///< [A/(N m)]
  double d_torque2 = 0.0;  ///< [A/(N m)^2]
};

/// Terminal voltage [V] with derivatives; those not listed (torque-rate, rate-rate) are zero.
struct MotorVoltage {
  double value = 0.0;      ///< [V]
  double d_torque = 0.0;   ///< [V/(N m)]
  double d_rate = 0.0;     ///< [V s/rad]
  double d_torque2 = 0.0;  ///< [V/(N m)^2]
};

/// Electric power [W] drawn by one motor (negative where it feeds back) with derivatives; rate-rate
/// is zero.
struct MotorPower {
  double value = 0.0;          ///< [W]
  double d_torque = 0.0;       ///< [W/(N m)]
  double d_rate = 0.0;         ///< [W s/rad]
  double d_torque2 = 0.0;      ///< [W/(N m)^2]
  double d_torque_rate = 0.0;  ///< [W s/(N m rad)]
};

/// Torque [N m] of friction at the joint, or against it, with its derivatives by the joint's rate.
struct MotorFriction {
  double value = 0.0;    ///< [N m]
  double d_rate = 0.0;   ///< [N m s/rad]
  double d_rate2 = 0.0;  ///< [N m s^2/rad^2]
};

/// Which limit holds a torque back.
enum class MotorLimit { none, current, torque };

/// A joint torque [N m] and the limit that bound it, MotorLimit::none where it is free.
struct LimitedTorque {
  double value = 0.0;
  MotorLimit limit = MotorLimit::none;
};

/// Current [A] of one motor at a joint torque [N m].
double motor_current(const model::PlanarMotor& motor, double joint_torque);
MotorCurrent motor_current_derivatives(const model::PlanarMotor& motor, double joint_torque);

/// Voltage [V] of one motor at a joint torque [N m] and joint rate [rad/s].
MotorVoltage motor_voltage(const model::PlanarMotor& motor, double joint_torque, double joint_rate);

/// Joint rate at which a motor's dry friction turns, s of s(w) [rad/s].
inline constexpr double kDryFrictionSmoothing = 0.1;
/// Friction at a joint rate [rad/s] of one motor.
MotorFriction motor_friction(const model::PlanarMotor& motor, double joint_rate);
/// What a motor gives against the dry part of it [N m], of the rate's sign.
MotorFriction against_dry_friction(const model::PlanarMotor& motor, double joint_rate);
/// Whether it has any.
bool rubs(const model::PlanarMotor& motor);

/// Electric power [W] of one motor at a joint torque [N m] and joint rate [rad/s].
MotorPower motor_power(const model::PlanarMotor& motor, double joint_torque, double joint_rate);

/// The motor torque before the gear [N m] at a current [A]: the one real root of c t^3 + a t = i,
/// by Halley's and Newton's iteration, deep in saturation in closed form; to the last digits. Needs
/// a >= 0 [A/(N m)], c >= 0 [A/(N m)^3], not both zero.
class MagneticSaturation {
 public:
  MagneticSaturation(double linear, double cubic);
  [[nodiscard]] double torque(double current) const;

 private:
  double linear_, cubic_;
  double corner_torque_ = 0.0;  ///< sqrt(a/c), where both terms are equal [N m]
  double per_current_ = 0.0;    ///< 1/(a corner torque) [1/A]
};

/// The same of one current.
double saturated_torque(double linear, double cubic, double current);

/// The joint torque [N m] at a terminal voltage [V] and joint rate [rad/s], no limit applied.
/// Inverse of motor_voltage.
double joint_torque_at_voltage(const model::PlanarMotor& motor, double voltage, double joint_rate);

/// The largest joint torque [N m] that current_limit and torque_limit allow, infinite where both
/// are; and which binds.
LimitedTorque largest_joint_torque(const model::PlanarMotor& motor);

/// joint_torque_at_voltage held within +- largest_joint_torque.
LimitedTorque limited_joint_torque_at_voltage(const model::PlanarMotor& motor, double voltage,
                                              double joint_rate);

}  // namespace jaculus::components
