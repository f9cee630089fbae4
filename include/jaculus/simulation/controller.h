#pragma once
// What drives a plant: a sampled loop with zero-order hold that turns a reference into a command
// for every motor.
//   command = feed-forward(t_k) + kp (reference position - measured)
//             + kd (reference velocity - measured rate),   t_k = k/rate
// in the controller's quantity: torque at the motor [N m], duty of the bus voltage [-], or voltage
// [V]. A torque command is what the driver's current loop makes, within the voltage, current and
// torque limits; duty and voltage go through winding and back-EMF (components/motor.h). The
// feed-forward's instants are the plan's own, between its samples interpolated as the plan holds
// its inputs. After the plan's end: hold its last pose, relax, repeat the last command, or go into
// a pose to land in (in YAML `after_end: {pose: {"*": 60 deg, tail: 0}, within: 50 ms}`; every
// motor needs a value).

#include <map>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/model/planar.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::simulation {

using trajectory::AfterEnd;
using trajectory::Quantity;

/// Reference for every motor against time, with the state that it begins in.
struct Reference {
  Vector time;                      ///< K samples, rising; equal at a border of phases [s]
  std::vector<std::string> motors;  ///< by joint
  Matrix position;                  ///< motors x K [rad]; empty: no position reference
  Matrix velocity;                  ///< motors x K [rad/s]
  /// motors x K, in the controller's quantity; torque: at the motor, before the gear [N m]
  Matrix feedforward;
  bool linear = false;                    ///< feed-forward linear between samples, else held
  std::map<std::string, double> initial;  ///< coordinates and motor joints at the start, SI
  double duration = 0.0;                  ///< [s]
};

struct Controller {
  Quantity quantity = Quantity::torque;  ///< torque, duty or voltage
  double rate_hz = 1000.0;               ///< [Hz]; infinite: continuous
  /// one a motor of the reference, at the motor: quantity a rad, quantity a rad/s of the motor
  /// shaft
  Vector kp, kd;
  Reference reference;
  AfterEnd after_end = AfterEnd::hold;
  /// Of AfterEnd::pose, one a motor of the reference [rad or m]. The position's reference leaves
  /// the plan's end with its rate and comes to rest in the pose `landing_time` later, on a cubic,
  /// and stays: with s = (t - T)/landing_time in [0, 1],
  ///   r = (1 + 2 s)(1 - s)^2 r_T + s (1 - s)^2 landing_time r_T' + s^2 (3 - 2 s) pose.
  Vector landing_pose;
  double landing_time = 0.0;  ///< [s], > 0 for a pose
};

/// The reference in a plan's table (plan.csv), for the motors of a robot. InputError where a joint
/// of the robot is missing. `quantity` says which column is the feed-forward; duty is the plan's
/// voltage over `bus_voltage`: a duty column counts in the plan's own voltage where its torques and
/// rates tell that, else in the bus's.
Reference plan_reference(const trajectory::Table& plan, const model::PlanarModel& model,
                         Quantity quantity, double bus_voltage, const std::filesystem::path& file);

/// The controller that a dataset states; unknown gains take the values of `gains` (by joint;
/// missing: zero).
struct AssumedGains {
  std::map<std::string, double> kp, kd;
};
Controller stated_controller(const trajectory::Dataset& dataset, const model::PlanarModel& model,
                             const AssumedGains& gains);

}  // namespace jaculus::simulation
