#pragma once
// Right-hand sides and Jacobians of the two bodies on a pin, for the Rosenbrock step. States are
// named at each system; equations and symbols are those of studies/reorientation.h.

#include <algorithm>
#include <cmath>

#include "jaculus/components/motor.h"
#include "jaculus/components/tail_drag.h"
#include "jaculus/studies/reorientation.h"
#include "studies/rosenbrock.h"

namespace jaculus::studies::detail {

/// The motor as a function of its torque t before the gear.
struct MotorCurve {
  double free_rate;       ///< V / (k_t G) [rad/s]
  double slope;           ///< R / (k_t G) [rad/s/A]
  double linear, cubic;   ///< a, c
  double ratio;           ///< G eta
  double largest_torque;  ///< at the joint [N m]

  explicit MotorCurve(const ReorientationCase& c)
      : free_rate(c.motor.voltage / (c.motor.torque_constant * c.motor.gear)),
        slope(c.motor.resistance / (c.motor.torque_constant * c.motor.gear)),
        linear(c.motor.saturation_linear),
        cubic(c.motor.saturation_cubic),
        ratio(c.motor.gear * c.motor.efficiency),
        largest_torque(c.motor_limits ? components::largest_joint_torque(c.motor).value
                                      : kInfinity) {}

  [[nodiscard]] double rate(double t) const {
    return free_rate - slope * t * (linear + cubic * t * t);
  }
  [[nodiscard]] double current_slope(double t) const { return linear + 3.0 * cubic * t * t; }
  [[nodiscard]] double rate_slope(double t) const { return -slope * current_slope(t); }
  [[nodiscard]] bool limited(double t) const { return std::abs(ratio * t) > largest_torque; }
  [[nodiscard]] double joint_torque(double t) const {
    return std::clamp(ratio * t, -largest_torque, largest_torque);
  }
};

/// Drag moment with its derivatives by the tail's absolute rate and angle.
struct AirMoment {
  double value, d_omega, d_psi;
};

/// The air around the tail; psi = thb + tht, from zero at the start.
struct Air {
  double b = 0.0;  ///< still air: moment = -b omega |omega| [N m s^2]
  bool still = true;
  model::PlanarDrag drag;
  Vec2 velocity = Vec2::Zero();  ///< of the pivot to the air [m/s]
  double phi0 = 0.0;             ///< absolute tail angle at psi = 0 [rad]

  explicit Air(const ReorientationCase& c);
  [[nodiscard]] AirMoment moment(double omega, double psi) const;
};

/// What a user wants to know of a state.
struct Motion {
  double body_angle, body_rate, tail_angle, tail_rate, joint_torque;
};

/// Inertias and the momentum's split.
struct Bodies {
  double body, tail, total, reduced_inverse;
  explicit Bodies(const ReorientationCase& c)
      : body(c.body_inertia),
        tail(c.tail_inertia),
        total(body + tail),
        reduced_inverse(1.0 / body + 1.0 / tail) {}
};

/// Stiff pin, still air. States: t [N m], H [N m s] | tht [rad], Int H dt [N m s^2].
struct RigidStill {
  enum { N = 2, Q = 2 };
  using State = StateOf<N, Q>;
  const Bodies& in;
  const MotorCurve& motor;
  const Air& air;

  [[nodiscard]] State rhs(const State& y) const {
    const double w = motor.rate(y[0]);
    const double omega = (y[1] + in.body * w) / in.total;
    const double drag = -air.b * omega * std::abs(omega);
    const double acceleration = motor.joint_torque(y[0]) * in.reduced_inverse + drag / in.tail;
    return {acceleration / motor.rate_slope(y[0]), drag, w, y[1]};
  }

  [[nodiscard]] Eigen::Matrix<double, N + Q, N> jacobian(const State& y) const {
    const double w_t = motor.rate_slope(y[0]);
    const double omega = (y[1] + in.body * motor.rate(y[0])) / in.total;
    const double drag_omega = -2.0 * air.b * std::abs(omega);
    const double drag_t = drag_omega * in.body * w_t / in.total;
    const double drag_h = drag_omega / in.total;
    const double drag = 0.5 * drag_omega * omega;
    const double a = motor.joint_torque(y[0]) * in.reduced_inverse + drag / in.tail;
    const double a_t =
        (motor.limited(y[0]) ? 0.0 : motor.ratio) * in.reduced_inverse + drag_t / in.tail;
    const double w_tt = -motor.slope * 6.0 * motor.cubic * y[0];
    Eigen::Matrix<double, N + Q, N> j;
    j << a_t / w_t - a * w_tt / (w_t * w_t), drag_h / (in.tail * w_t),  //
        drag_t, drag_h,                                                 //
        w_t, 0.0,                                                       //
        0.0, 1.0;
    return j;
  }

  [[nodiscard]] State start() const {
    return {components::saturated_torque(motor.linear, motor.cubic, motor.free_rate / motor.slope),
            0, 0, 0};
  }
  [[nodiscard]] State scale(double duration) const {
    return {start()[0], in.total / duration, 1.0, in.total};
  }
  [[nodiscard]] Motion motion(const State& y) const {
    const double w = motor.rate(y[0]);
    return {(y[3] - in.tail * y[2]) / in.total, (y[1] - in.tail * w) / in.total, y[2], w,
            motor.joint_torque(y[0])};
  }
};

/// Stiff pin in moving air. States: t, H, psi | tht.
struct RigidWind {
  enum { N = 3, Q = 1 };
  using State = StateOf<N, Q>;
  const Bodies& in;
  const MotorCurve& motor;
  const Air& air;

  [[nodiscard]] State rhs(const State& y) const;
  [[nodiscard]] Eigen::Matrix<double, N + Q, N> jacobian(const State& y) const;
  [[nodiscard]] State start() const;
  [[nodiscard]] State scale(double duration) const;
  [[nodiscard]] Motion motion(const State& y) const;
};

/// A spring at the root, any air. States: delta [rad], H, omega = psi', psi | tht.
struct Sprung {
  enum { N = 4, Q = 1 };
  using State = StateOf<N, Q>;
  const Bodies& in;
  const MotorCurve& motor;
  const Air& air;
  double stiffness;

  [[nodiscard]] State rhs(const State& y) const;
  [[nodiscard]] Eigen::Matrix<double, N + Q, N> jacobian(const State& y) const;
  [[nodiscard]] State start() const;
  [[nodiscard]] State scale(double duration) const;
  [[nodiscard]] Motion motion(const State& y) const;
};

/// Body and tail locked at the stop, any air. States: omega, psi.
struct Locked {
  enum { N = 2, Q = 0 };
  using State = StateOf<N, Q>;
  const Bodies& in;
  const Air& air;
  double tail_angle;

  [[nodiscard]] State rhs(const State& y) const;
  [[nodiscard]] Eigen::Matrix<double, N + Q, N> jacobian(const State& y) const;
  [[nodiscard]] State scale(double duration) const { return {1.0 / duration, 1.0}; }
  [[nodiscard]] Motion motion(const State& y) const {
    return {y[1] - tail_angle, y[0], tail_angle, 0.0, 0.0};
  }
};

}  // namespace jaculus::studies::detail
