#pragma once
// The plant: a robot as a value that can be simulated. `nominal_plant` believes robot.yaml (rigid
// joints without other friction than the motors have there, Coulomb feet on rigid floor, ideal
// battery, no delay); effects (effects/effect.h) edit the value, nothing else knows of them.
//
// Every component parameter below has a nominal value at which the plant does bit for bit what it
// does without the component.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/simulation/law.h"

namespace jaculus::simulation {

/// Friction torque at a joint beside what its motor has in the model, opposing its rate w [rad/s]:
///   tau = -s(w) [coulomb + load |tau_motor| + (stribeck) exp(-(w/stribeck_rate)^2)
///                + load_stribeck |tau_motor| exp(-(w/load_stribeck_rate)^2)
///                + positive (1 + s(w))/2 + negative (1 - s(w))/2] - viscous w,
///     s(w) = tanh(w/smoothing_rate).
/// Left and right of a pair: values of one joint, counted `count` times as its motor is.
struct JointFriction {
  std::string joint;
  double coulomb = 0.0;        ///< [N m]
  double viscous = 0.0;        ///< [N m s/rad]
  double stribeck = 0.0;       ///< added at rest, fades with speed [N m]
  double stribeck_rate = 1.0;  ///< [rad/s]
  double load = 0.0;           ///< share of the motor's torque that friction takes [-]
  /// below it a joint counts as at rest, where dry friction holds it; 0.3 deg/s [rad/s, m/s]
  double smoothing_rate = 0.005;
  double positive = 0.0;       ///< dry friction while the joint's angle grows alone [N m]
  double negative = 0.0;       ///< and while it falls alone [N m]
  double load_stribeck = 0.0;  ///< share of the motor's torque added at rest, fades with speed [-]
  double load_stribeck_rate = 1.0;  ///< [rad/s]
};

/// A compliant transmission behind a motor: the joint splits into the motor's side (keeps the
/// coordinate's name, carries the reflected rotor inertia) and a hinge coordinate `<joint>_hinge`
/// [rad] between it and the link, at which
///   tau = -d(hinge)/compliance - damping d(hinge)',
///     d: the hinge angle beyond the dead band +-play/2, round at its corners.
/// compliance 0 and play 0: no hinge is there. With play alone, the flanks have a stiffness that
/// grows as 1/play, so that the influence of a small play is proportional to it.
struct Transmission {
  std::string joint;
  double compliance = 0.0;     ///< 1/stiffness [rad/(N m)]
  double damping_ratio = 0.0;  ///< of the link on the spring, motor held [-]
  double play = 0.0;           ///< total dead band at the joint [rad]
};

/// Battery: V_bus = voltage(motor) - resistance * (sum of motor currents drawn), solved with the
/// motors' currents.
struct Battery {
  double resistance = 0.0;  ///< internal [ohm]
};

/// Winding heat: T' = heat * i^2 R per motor (adiabatic within a leap); R = R_0 (1 + 0.0039 T), k_t
/// = k_t0 (1 - 0.001 T).
struct Winding {
  double heat = 0.0;     ///< [K/J]
  double initial = 0.0;  ///< above the temperature of the stated resistance [K]
};

/// Commands reach the motors `delay` after their sample; `late_start` shifts the plan as a whole.
/// What the motors make of a command c follows it as T u' = c - u (a current loop, a winding's
/// L/R), from the first command on.
/// A sampled controller reads rates through a low pass of time constant T, `velocity_filter`:
/// f += (v - f)/(1 + T rate) (backward Euler's discretisation, as firmware has it); f starts at v.
/// On a ramp it reads what was T ago.
/// While both switches of a half bridge are off, the current picks the diode that opposes it: a
/// driver that is told a voltage or a duty loses up to V_d = dead_time V_bus against the current
/// (Jeong and Park, The analysis and compensation of dead-time effects in PWM inverters, IEEE
/// Trans. Industrial Electronics 38(2), 1991): the time that both are off times the frequency, for
/// each half bridge that switches and has the current in it. A loop of the current makes up for it
/// up to the bus voltage, so that less voltage is all that is left of it there.
struct Actuation {
  double delay = 0.0;              ///< [s]
  double lag = 0.0;                ///< time constant T of the torque, below [s]
  double velocity_filter = 0.0;    ///< time constant of the rates that the controller reads [s]
  double dead_time = 0.0;          ///< largest voltage that drivers lose to it, of the bus's [-]
  double late_start = 0.0;         ///< [s]
  double gain_scale_p = 1.0;       ///< on every kp that the controller states [-]
  double gain_scale_d = 1.0;       ///< on every kd [-]
  double feedforward_scale = 1.0;  ///< on the commanded quantity [-]
  std::map<std::string, double> torque_scale;  ///< by joint, on the torque that arrives there [-]
  /// by joint with a motor: constant, beside what the motor is told and its log says (a current
  /// sensor or an amplifier that is not zero at zero), of each of a pair [N m, N where it slides]
  std::map<std::string, double> torque_offset;
};

/// What sensors make of the motion. Offsets and scales by channel name ("x", "pitch", "front_a",
/// ...).
struct Sensing {
  std::map<std::string, double> latency;  ///< by stream, [s]
  std::map<std::string, double> scale;    ///< [-]
  /// SI; also seen by the controller where it reads the channel
  std::map<std::string, double> offset;
  /// Time constant [s] of a first-order low pass through which a channel goes into the log, as of a
  /// driver's ammeter. The controller reads without it.
  std::map<std::string, double> filter;
  /// What a log has in place of a value, scaled and offset, at the time t it is of [s]; in the
  /// channel's unit. The controller reads without it.
  std::map<std::string, std::function<double(double value, double t)>> laws;
  Vec2 tracked_point = Vec2::Zero();  ///< of the base, that motion capture tracks, in its frame [m]
  double mocap_tilt = 0.0;  ///< of motion capture's axes about +y, the x axis pointing down [rad]
};

/// Floor under every contact point. Rigid where compliance is 0; else a spring-damper pushing only:
///   f_z = max(0, depth/compliance + 2 damping_ratio sqrt(m/compliance) depth'),
///     m: the robot's mass over its number of feet.
struct Ground {
  double friction = 0.0;       ///< Coulomb coefficient [-]
  double compliance = 0.0;     ///< [m/N], one foot of a pair
  double damping_ratio = 0.0;  ///< of that mass on one foot's spring [-]
  double height = 0.0;         ///< of the floor [m]
  /// feet roll on a circle of this radius about the model's toe point [m]
  double foot_radius = 0.0;
};

/// End of a joint's range, an impact of the two links with restitution. One whose joint is not
/// listed has no stop.
struct JointStop {
  std::string joint;
  Bounds range;              ///< [rad]
  double restitution = 0.0;  ///< [-]; 0: they lock until the torque pulls them apart
};

/// A force by the world over a time: a one-off disturbance, or one box of a force that the model
/// lacks.
struct Push {
  double start = 0.0, duration = 0.0;  ///< [s]
  Vec2 force_W = Vec2::Zero();         ///< on the base, at its origin [N]
  double moment = 0.0;                 ///< on the base, about +y [N m]
  std::string joint{};                 ///< at which `torque` acts; empty: none
  double torque = 0.0;  ///< at that joint, of each of a pair [N m, N where it slides]
  /// Whether it swells and fades as half a sine, of which the values are the peak.
  bool half_sine = false;

  /// What share of its values acts at a time while it does [-].
  [[nodiscard]] double share_at(double t) const;
};

struct Plant {
  /// masses, inertias, geometry, motors (k_t, R, saturation, voltage, limits), drag
  model::PlanarModel model;
  std::vector<JointFriction> friction;
  std::vector<Transmission> transmissions;
  Battery battery;
  Winding winding;
  Actuation actuation;
  Sensing sensing;
  Ground ground;
  std::vector<JointStop> stops;
  /// points of the model that may hit the floor, besides its feet
  std::vector<std::string> ground_points;
  std::vector<Push> pushes;
  std::vector<Law> laws;         ///< of users
  double drag_smoothing = 0.02;  ///< eps of tail_drag.h [m/s]
  /// by which gravity leans from -z towards +x: of a base that is held nose-down by it [rad]
  double gravity_tilt = 0.0;
};

/// The robot as robot.yaml has it.
Plant nominal_plant(const model::PlanarModel& model);

}  // namespace jaculus::simulation
