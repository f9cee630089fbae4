#include "studies/reorientation_systems.h"

namespace jaculus::studies::detail {

Air::Air(const ReorientationCase& c)
    : drag(c.drag), velocity(c.pivot_velocity - c.drag.wind_W), phi0(c.initial_tail_angle) {
  still = drag.kind == model::DragKind::none || drag.kind == model::DragKind::rotation ||
          velocity.isZero(0.0);
  // In still air every kind is b omega |omega|, so one evaluation at 1 rad/s gives b.
  b = -components::drag_load(drag, 0.0, 1.0, 0.0).moment;
}

AirMoment Air::moment(double omega, double psi) const {
  if (still) return {-b * omega * std::abs(omega), -2.0 * b * std::abs(omega), 0.0};
  const double phi = phi0 + psi;
  const Vec2 n = components::drag_normal(drag, phi);
  // dn/dphi = R'' direction = -R direction, and R direction is n turned back by a right angle.
  const double s = n.dot(velocity);
  const double s_phi = -Vec2(-n.y(), n.x()).dot(velocity);
  const components::DragLoad load = components::drag_load(drag, s, omega, 0.0);
  return {load.moment, load.d(1, 1), load.d(1, 0) * s_phi};
}

RigidWind::State RigidWind::rhs(const State& y) const {
  const double w = motor.rate(y[0]);
  const double omega = (y[1] + in.body * w) / in.total;
  const double drag = air.moment(omega, y[2]).value;
  const double acceleration = motor.joint_torque(y[0]) * in.reduced_inverse + drag / in.tail;
  return {acceleration / motor.rate_slope(y[0]), drag, omega, w};
}

Eigen::Matrix<double, 4, 3> RigidWind::jacobian(const State& y) const {
  const double w_t = motor.rate_slope(y[0]);
  const double omega_t = in.body * w_t / in.total;
  const double omega_h = 1.0 / in.total;
  const AirMoment m = air.moment((y[1] + in.body * motor.rate(y[0])) * omega_h, y[2]);
  const double a = motor.joint_torque(y[0]) * in.reduced_inverse + m.value / in.tail;
  const double a_t = (motor.limited(y[0]) ? 0.0 : motor.ratio) * in.reduced_inverse +
                     m.d_omega * omega_t / in.tail;
  const double w_tt = -motor.slope * 6.0 * motor.cubic * y[0];
  Eigen::Matrix<double, 4, 3> j;
  //
  j << a_t / w_t - a * w_tt / (w_t * w_t), m.d_omega * omega_h / (in.tail * w_t),
      m.d_psi / (in.tail * w_t), m.d_omega * omega_t, m.d_omega * omega_h, m.d_psi,  //
      omega_t, omega_h, 0.0,                                                         //
      w_t, 0.0, 0.0;
  return j;
}

RigidWind::State RigidWind::start() const {
  return {components::saturated_torque(motor.linear, motor.cubic, motor.free_rate / motor.slope),
          0.0, 0.0, 0.0};
}

RigidWind::State RigidWind::scale(double duration) const {
  return {start()[0], in.total / duration, 1.0, 1.0};
}

Motion RigidWind::motion(const State& y) const {
  const double w = motor.rate(y[0]);
  return {y[2] - y[3], (y[1] - in.tail * w) / in.total, y[3], w, motor.joint_torque(y[0])};
}

// The motor's torque is the spring's, t = k delta / (G eta), and so gives the motor's rate.
Sprung::State Sprung::rhs(const State& y) const {
  const double body_rate = (y[1] - in.tail * y[2]) / in.body;
  const double tail_rate = y[2] - body_rate;
  const double drag = air.moment(y[2], y[3]).value;
  State f;
  f << motor.rate(stiffness * y[0] / motor.ratio) - tail_rate, drag,
      (stiffness * y[0] + drag) / in.tail, y[2], tail_rate;
  return f;
}

Eigen::Matrix<double, 5, 4> Sprung::jacobian(const State& y) const {
  const AirMoment m = air.moment(y[2], y[3]);
  const double rate_h = -1.0 / in.body;
  const double rate_omega = 1.0 + in.tail / in.body;
  const double stretch = motor.rate_slope(stiffness * y[0] / motor.ratio) * stiffness / motor.ratio;
  Eigen::Matrix<double, 5, 4> j;
  j << stretch, -rate_h, -rate_omega, 0.0,                               //
      0.0, 0.0, m.d_omega, m.d_psi,                                      //
      stiffness / in.tail, 0.0, m.d_omega / in.tail, m.d_psi / in.tail,  //
      0.0, 0.0, 1.0, 0.0,                                                //
      0.0, rate_h, rate_omega, 0.0;
  return j;
}

Sprung::State Sprung::start() const { return State::Zero(); }

Sprung::State Sprung::scale(double duration) const {
  const double stall = motor.ratio * components::saturated_torque(motor.linear, motor.cubic,
                                                                  motor.free_rate / motor.slope);
  State s;
  s << std::min(stall / stiffness, 1.0), in.total / duration, 1.0 / duration, 1.0, 1.0;
  return s;
}

Motion Sprung::motion(const State& y) const {
  const double body_rate = (y[1] - in.tail * y[2]) / in.body;
  return {y[3] - y[4], body_rate, y[4], y[2] - body_rate, stiffness * y[0]};
}

Locked::State Locked::rhs(const State& y) const {
  return {air.moment(y[0], y[1]).value / in.total, y[0]};
}

Eigen::Matrix<double, 2, 2> Locked::jacobian(const State& y) const {
  const AirMoment m = air.moment(y[0], y[1]);
  Eigen::Matrix2d j;
  j << m.d_omega / in.total, m.d_psi / in.total, 1.0, 0.0;
  return j;
}

}  // namespace jaculus::studies::detail
