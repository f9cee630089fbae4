#pragma once
// Aerial reorientation by a tail: two bodies on a pin, motor at a constant voltage from rest.
//
//   I_b thb'' = -T,    I_t (thb'' + tht'') = T + tau_D                          (equations 3 and 4)
//   T = G eta f(i),    i = (V - k_t G tht') / R,    f^-1(t) = a t + c t^3       (equations 5 to 7)
//   tau_D = moment of tail_drag.h at omega = thb' + tht' and the wind's s       (equations 2 and 8)
// thb: body's angle in the world, tht: tail's angle to the body, I_b, I_t: inertias about the pin.
// A positive voltage swings the tail to positive tht and the body the other way. At tht = stroke
// the tail meets its stop: a plastic impact that keeps the angular momentum I_b thb' + I_t (thb' +
// tht'), after which the pair turns locked together under drag. With a root spring (section VI-E)
// the motor sits at tht + delta, k delta = T, and a massless rotor.
//
//   effectiveness = |thb| / tht at the end of the duration. Without drag it is I_t / (I_b + I_t)
//       for any motor.
// Source: Norby et al. 2021, sections II, III and VI.
//
// Integration. A light tail behind a high gear is stiff (rates of 1e5 a second), so an L-stable
// Rosenbrock method of order 4 is used, with the motor torque t in place of the rate: tht' = (V - R
// (a t + c t^3)) / (k_t G) is a polynomial, and the saturation never needs to be inverted. The
// second state is the momentum, so that what conserves it does so to the last digit. Events are hit
// by steps of the right size, not by interpolation; the locked pair in still air has a closed form:
//   thb'(s) = w / (1 + b |w| s / I),  thb(s) = thb + sign(w) (I/b) ln(1 + b |w| s / I),
//     I = I_b + I_t.
//
// Limits of validity: no gravity moment on the tail, no rotor inertia, pin without friction; the
// pivot moves at a constant velocity (its own, not changed by drag).

#include <optional>
#include <string>
#include <vector>

#include "jaculus/model/planar.h"

namespace jaculus::studies {

/// A task for one tail on one body.
struct ReorientationCase {
  double body_inertia = 0.0;  ///< I_b about the pin [kg m^2], > 0
  double tail_inertia = 0.0;  ///< I_t about the pin [kg m^2], > 0
  model::PlanarMotor motor;   ///< with its gear, and `voltage` applied from the start
  bool motor_limits = false;  ///< hold the torque within the motor's current and torque limits
  model::PlanarDrag drag;  ///< kind none or rotation; distributed or point to feel the air's motion
  /// of the pin in the world (x forward, z up) [m/s]; needs a drag that feels it
  Vec2 pivot_velocity = Vec2::Zero();
  /// absolute angle phi of the tail at the start, for the wind only [rad]
  double initial_tail_angle = 0.0;
  double stroke = 0.0;                ///< tail angle at the stop [rad], > 0
  double duration = 0.0;              ///< [s], > 0
  double target_angle = 0.0;          ///< body rotation to be timed [rad], > 0
  double root_stiffness = kInfinity;  ///< torsion spring between motor and tail [N m/rad], > 0
};

/// What happened at the stop.
struct StopEvent {
  double time = 0.0;              ///< [s]
  double body_angle = 0.0;        ///< signed [rad]
  double tail_rate = 0.0;         ///< tht' just before [rad/s]
  double body_rate_before = 0.0;  ///< [rad/s]
  double body_rate_after = 0.0;   ///< [rad/s]
  double momentum_before = 0.0;   ///< [N m s]
  double momentum_after = 0.0;    ///< [N m s]
  double impulse = 0.0;           ///< angular impulse that stops the tail, on the tail [N m s]
};

struct ReorientationResult {
  bool converged =
      /// false: the integrator ran out of steps or met a non-finite state; nothing else counts then
      false;
  double body_angle = 0.0;               ///< thb at the end, signed [rad]
  double body_rate = 0.0;                ///< [rad/s]
  double tail_angle = 0.0;               ///< tht at the end [rad]
  double tail_rate = 0.0;                ///< tht' at the end [rad/s]
  double effectiveness = 0.0;            ///< |thb| / tht
  std::optional<StopEvent> stop;         ///< where the tail reached its stop
  std::optional<double> time_to_target;  ///< first time at which |thb| = target_angle [s]
  double rotation_after_stop = 0.0;      ///< |thb| gained after the stop [rad]
  int steps = 0;                         ///< accepted
};

/// One sample of a motion.
struct ReorientationSample {
  double time = 0.0;          ///< [s]
  double body_angle = 0.0;    ///< [rad]
  double body_rate = 0.0;     ///< [rad/s]
  double tail_angle = 0.0;    ///< [rad]
  double tail_rate = 0.0;     ///< [rad/s]
  double joint_torque = 0.0;  ///< on the tail by the motor [N m]; zero once locked
};

/// Relative local error of the integrator that keeps the effectiveness within 1e-5 (a benchmark
/// measures it).
inline constexpr double kReorientationTolerance = 1e-5;

/// Plays one case. `history`, where given, receives the steps taken (ends of steps, and the stop
/// twice: before and after). Needs the case to be valid (see check_case).
ReorientationResult simulate_reorientation(const ReorientationCase& c,
                                           double tolerance = kReorientationTolerance,
                                           std::vector<ReorientationSample>* history = nullptr);

/// What is wrong with a case, in a sentence for users; empty where nothing is.
std::string check_case(const ReorientationCase& c);

/// Time to fall a height from rest, sqrt(2 h / g) [s].
double fall_time(double height);

/// The case with which the paper works: Table I, gear 4, drag by equation 2, one body length of
/// fall, stroke 180 degrees, target 90 degrees.
ReorientationCase paper_case();

}  // namespace jaculus::studies
