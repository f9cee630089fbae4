#pragma once
// A motion of a robot over time: a plan or a simulated run. Samples are columns; at the border of
// two phases the same instant stands twice, once as the end of the one and once as the start of the
// other.

#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::trajectory {

/// A phase and the samples that belong to it.
struct PhaseSpan {
  std::string name;
  std::vector<std::string> contacts;  ///< feet on the ground
  int first = 0;                      ///< index of its first sample
  int last = 0;                       ///< index of its last sample
};

struct Trajectory {
  std::vector<std::string> coordinates;  ///< n generalised coordinates
  std::vector<bool> angular;             ///< n: rad where true, m otherwise
  std::vector<std::string> joints;       ///< m joints, dependent ones too
  std::vector<std::string> motors;       ///< joints that have a motor, u of them
  std::vector<std::string> feet;         ///< f
  std::vector<PhaseSpan> phases;
  /// "held": an input counts from its sample to the next interval; "linear"
  std::string input_hold;
  std::vector<int> interval_start;  ///< samples at which an input interval begins

  Vector time;              ///< [s], never falling
  Matrix position;          ///< n x samples [rad or m]
  Matrix velocity;          ///< n x samples
  Matrix acceleration;      ///< n x samples
  Matrix joint_position;    ///< m x samples [rad]
  Matrix joint_velocity;    ///< m x samples [rad/s]
  Matrix torque;            ///< u x samples, one motor's at the joint, behind its gear [N m]
  Matrix motor_torque;      ///< u x samples, before the gear [N m]
  Matrix current;           ///< u x samples, one motor's [A]
  Matrix voltage;           ///< u x samples, one motor's [V]
  Matrix force_x, force_z;  ///< f x samples, left and right summed [N]

  [[nodiscard]] int samples() const { return count_of(time); }
};

/// The columns of plan.csv, by quantity: time, phase; positions, then velocities, of the
/// coordinates that are no joints and of all joints; accelerations of the coordinates; torque,
/// motor torque, current, voltage of the motors; foot forces. A quantity whose matrix has no rows
/// is left out.
Table to_table(const Trajectory& trajectory);

}  // namespace jaculus::trajectory
