// Resampling of a plan at a fixed rate, and its limits afterwards.

#include <algorithm>
#include <cassert>
#include <cmath>

#include "jaculus/components/motor.h"
#include "jaculus/export/export.h"

namespace jaculus::exporting {
namespace {

// a plan that stands on its limit stays there within what a resampling shifts it
constexpr double kLimitMargin = 1e-3;

using trajectory::Quantity;
using Values = Eigen::Ref<const Vector>;

/// The row in force at `t`: the last one that is not later, so that at the border of two phases the
/// later one counts.
Eigen::Index row_at(const Values& time, double t) {
  const double* begin = time.data();
  const auto after = std::upper_bound(begin, begin + time.size(), t) - begin;
  return std::max<Eigen::Index>(0, after - 1);
}

/// Cubic through positions and velocities at both ends of the interval that holds t; returns
/// {position, velocity}.
Vec2 cubic(const Values& time, const Values& p, const Values& v, double t) {
  const Eigen::Index i = row_at(time, t);
  if (i + 1 >= time.size()) return {p[i], v[i]};
  const double h = time[i + 1] - time[i];
  const double s = (t - time[i]) / h;
  const double slope = (p[i + 1] - p[i]) / h;
  const double c2 = 3.0 * slope - 2.0 * v[i] - v[i + 1];
  const double c3 = v[i] + v[i + 1] - 2.0 * slope;
  return {p[i] + h * s * (v[i] + s * (c2 + s * c3)), v[i] + s * (2.0 * c2 + 3.0 * s * c3)};
}

/// Between row i and the next one.
double torque_within(const Values& time, const Values& torque, Eigen::Index i, double t,
                     bool linear) {
  if (!linear || i + 1 >= time.size() || time[i + 1] <= time[i]) return torque[i];
  return torque[i] + (t - time[i]) / (time[i + 1] - time[i]) * (torque[i + 1] - torque[i]);
}

/// What dry friction takes on average over [from, to], or at `from` where that is an instant, by
/// the law of the plan at the velocity of each instant.
double mean_against_friction(const model::PlanarMotor& motor, const Values& time, const Values& p,
                             const Values& v, double from, double to) {
  // within a sample of 2 ms a light joint (1e4 rad/s^2) turns in a step or two of these, and what
  // the mean is off by is that share of the friction
  constexpr int kSteps = 64;
  if (motor.dry_friction == 0.0) return 0.0;
  const auto against = [&](double t) {
    return components::against_dry_friction(motor, cubic(time, p, v, t)[1]).value;
  };
  if (to <= from) return against(from);

  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) sum += against(from + (to - from) * (i + 0.5) / kSteps);
  return sum / kSteps;
}

/// The plan's torque less what it has against dry friction at its samples.
Vector without_friction(const model::PlanarMotor& motor, const Values& v, Vector tau) {
  for (Eigen::Index i = 0; i < tau.size(); ++i)
    tau[i] -= components::against_dry_friction(motor, v[i]).value;
  return tau;
}

/// Over [from, to]; the torque in force at `from` where that is an instant.
double mean_torque(const Values& time, const Values& torque, double from, double to, bool linear) {
  Eigen::Index i = row_at(time, from);
  if (to <= from) return torque_within(time, torque, i, from, linear);

  double impulse = 0.0;
  for (double t = from; t < to; ++i) {
    const bool last = i + 1 >= time.size();
    const double end = last ? to : std::min(time[i + 1], to);
    if (end > t) impulse += (end - t) * torque_within(time, torque, i, 0.5 * (t + end), linear);
    t = end;
  }
  return impulse / (to - from);
}

model::PlanarMotor motor_of(const solver::MotorFigures& f) {
  model::PlanarMotor motor;
  motor.joint = f.joint;
  motor.torque_constant = f.torque_constant;
  motor.resistance = f.resistance;
  motor.saturation_linear = f.saturation_linear;
  motor.saturation_cubic = f.saturation_cubic;
  motor.gear = f.gear;
  motor.efficiency = f.efficiency;
  motor.dry_friction = f.dry_friction;
  return motor;
}

/// Keeps the largest absolute value and when it occurred.
void raise(LimitCheck& check, double value, double time) {
  if (std::abs(value) <= check.peak) return;
  check.peak = std::abs(value);
  check.time = time;
}

/// One motor at joint side, with what its limits saw.
ExportedMotor sample(const Source& source, const solver::MotorFigures& figures, const Export& plan,
                     std::vector<LimitCheck>& checks) {
  const trajectory::Table& table = source.table;
  const Vector time = table.values.col(table.column("time"));
  const Vector p = table.values.col(table.column(figures.joint));
  const Vector v = table.values.col(table.column(figures.joint + "_velocity"));
  const model::PlanarMotor motor = motor_of(figures);
  const Vector tau =
      without_friction(motor, v, table.values.col(table.column(figures.joint + "_torque")));
  const bool linear = source.hold == transcription::InputHold::linear;
  const double t0 = time[0];
  LimitCheck torque{figures.joint, Quantity::torque, "N m", 0.0, 0.0, figures.torque_limit, false};
  LimitCheck current{figures.joint, Quantity::current, "A", 0.0, 0.0, figures.current_limit, false};
  LimitCheck voltage{figures.joint, Quantity::voltage, "V", 0.0, 0.0, figures.voltage_limit, false};
  LimitCheck speed{figures.joint, Quantity::velocity,  "rad/s", 0.0,
                   0.0,           figures.speed_limit, false};
  ExportedMotor out;
  out.joint = figures.joint;
  out.slides = figures.slides;
  out.file_joints = figures.file_joints;
  if (out.file_joints.empty()) out.file_joints = {{figures.joint, 1.0}};

  for (const double t : plan.time) {
    const Vec2 state = cubic(time, p, v, t0 + t);
    const double end = std::min(t + 1.0 / plan.rate, plan.duration);
    const double held = mean_torque(time, tau, t0 + t, t0 + end, linear) +
                        mean_against_friction(motor, time, p, v, t0 + t, t0 + end);
    out.position.push_back(state[0]);
    out.velocity.push_back(state[1]);
    out.torque.push_back(held);
    if (!source.limits_known) continue;
    out.current.push_back(components::motor_current(motor, held));
    out.voltage.push_back(components::motor_voltage(motor, held, state[1]).value);
    raise(torque, held / (motor.gear * motor.efficiency), t);
    raise(current, out.current.back(), t);
    raise(voltage, out.voltage.back(), t);
    const double velocity_at_end = cubic(time, p, v, t0 + end)[1];
    raise(voltage, components::motor_voltage(motor, held, velocity_at_end).value, end);
    raise(speed, motor.gear * state[1], t);
    raise(speed, motor.gear * velocity_at_end, end);
  }

  if (source.limits_known) {
    for (LimitCheck* check : {&torque, &current, &voltage, &speed}) {
      check->exceeded = check->peak > check->limit * (1.0 + kLimitMargin);
      checks.push_back(*check);
    }
  }

  return out;
}

void to_motor_side(ExportedMotor& motor, const solver::MotorFigures& figures) {
  for (double& position : motor.position) position *= figures.gear;
  for (double& velocity : motor.velocity) velocity *= figures.gear;
  for (double& torque : motor.torque) torque /= figures.gear * figures.efficiency;
}

}  // namespace

std::vector<PlayedJoint> played_joints(const Export& plan) {
  std::vector<PlayedJoint> joints;
  for (const ExportedMotor& motor : plan.motors) {
    for (const model::FileJoint& joint : motor.file_joints)
      joints.push_back({joint.name, joint.sign, &motor, joint.attached});
  }
  return joints;
}

Export resample(const Source& source, double rate, Side side) {
  assert(rate > 0.0);
  const auto time = source.table.values.col(source.table.column("time"));
  Export plan;
  plan.name = source.name;
  plan.rate = rate;
  plan.duration = time[time.size() - 1] - time[0];
  plan.side = side;
  plan.plan_hold = source.hold;
  plan.held_joints = source.held_joints;
  constexpr double kRounding = 1e-9;  // a sample that falls on the end but for rounding is one
  const auto samples =
      static_cast<std::size_t>(std::floor(plan.duration * rate * (1.0 + kRounding))) + 1;
  for (std::size_t k = 0; k < samples; ++k) plan.time.push_back(static_cast<double>(k) / rate);
  for (const solver::MotorFigures& figures : source.motors) {
    plan.motors.push_back(sample(source, figures, plan, plan.checks));
    plan.file_joints_known = plan.file_joints_known && !figures.file_joints.empty();
    if (side == Side::motor) to_motor_side(plan.motors.back(), figures);
  }
  return plan;
}

}  // namespace jaculus::exporting
