#pragma once
// A law: forces on a plant, or values of its drives and ground, that follow from what it reads,
// from time and from states of its own. What users write as an effect becomes a law
// (effects/user_effect.h); a program can write one in C++.
//
// States x of a law are states of the run beside q and v:
//     (q, v, x)' = (v, a(q, v, x, t), g(q, v, x, t)).
// One method integrates all of them, so x has the order and the tolerance of the motion, and a hold
// of the commands is no step of x. Of x/scale the integrator sees the error beside its absolute
// tolerance.
//
// In a run the order is: actions before the motors (their readings of motors are 0), the motors,
// then forces and rates.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::simulation {

enum class ReadingKind {
  time,            ///< since the run's start [s]
  joint_position,  ///< on the motor's side [rad, m where it slides]
  joint_rate,      ///< [rad/s, m/s]
  /// what gravity and motion exert there, -row.h/(count row.row) with h the bias force and row
  /// d(joint)/dq, of each of a pair [N m, N]
  joint_load,
  motor_torque,   ///< of one motor at its joint [N m, N]
  motor_current,  ///< of one motor [A]
  motor_voltage,  ///< at its terminals [V]
  motor_limit,    ///< torque at its joint that its current and torque limits allow [N m, N]
  bus_voltage,    ///< [V]
  point_x,        ///< of a body's point, world frame [m]
  point_z,        ///< [m]
  point_rate_x,   ///< [m/s]
  point_rate_z,   ///< [m/s]
  body_angle,     ///< absolute, about +y, in (-pi, pi] [rad]
  body_rate,      ///< [rad/s]
  sensor_value    ///< of a sensor's law (Sensing::laws) alone, in the channel's unit
};

/// Whether it is of one motor.
bool is_of_motor(ReadingKind kind);

/// What a law reads of the plant.
struct Reading {
  ReadingKind kind = ReadingKind::time;
  std::string of{};           ///< a joint or a body, by its name
  Vec2 point = Vec2::Zero();  ///< in the body's frame [m]

  bool operator==(const Reading&) const = default;
};

enum class ActionKind {
  joint_torque,   ///< torque at a joint, of each of a pair [N m, N where it slides]
  point_force,    ///< two values: x, z on a body's point, of each of a pair, world frame [N]
  body_moment,    ///< about +y, of each of a pair [N m]
  torque_scale,   ///< before the motors: what arrives of a joint's motor torque [-]
  bus_drop,       ///< before the motors: what the battery lacks of its voltage [V]
  friction_scale  ///< before the motors: on Coulomb's coefficient of the ground, at least 0 [-]
};

/// What a law does to the plant.
struct Action {
  ActionKind kind = ActionKind::joint_torque;
  std::string of{};           ///< a joint or a body, by its name
  Vec2 point = Vec2::Zero();  ///< in the body's frame [m]

  [[nodiscard]] int values() const { return kind == ActionKind::point_force ? 2 : 1; }
  [[nodiscard]] bool before_motors() const {
    return kind == ActionKind::torque_scale || kind == ActionKind::bus_drop ||
           kind == ActionKind::friction_scale;
  }
};

/// A law's functions, for one run in one thread, of their arguments alone: they are also called at
/// states that no motion comes to. `readings`, `actions` and `states` in the law's order, an
/// action's values side by side; what is not known yet is 0.
struct LawFunctions {
  /// Sets the actions before the motors; null where there is none.
  std::function<void(const double* readings, const double* states, double* actions)> before;
  /// Sets all other actions, and the states' rates [unit/s].
  std::function<void(const double* readings, const double* states, double* actions, double* rates)>
      act;
};

struct LawState {
  double initial = 0.0;  ///< at the run's start, in its own unit
  double scale = 1.0;    ///< typical size, in its own unit
};

struct Law {
  std::string name;  ///< for messages
  std::vector<Reading> readings;
  std::vector<Action> actions;
  std::vector<LawState> states;
  std::function<LawFunctions()> functions;  ///< new ones for each run
};

}  // namespace jaculus::simulation
