#pragma once
// What the testbed's motors are told, and how its loop sees the joints.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::testbed {

/// What the robot is told to do. Joints by their planar names, one row a motor; left and right hear
/// the same.
struct Commands {
  /// Torque before the gear [N m], duty [-] or voltage [V].
  trajectory::Quantity quantity = trajectory::Quantity::torque;
  double rate_hz = 1000.0;
  std::vector<std::string> motors;
  Vector time;  ///< of the reference, never falling [s]
  /// motors x samples [rad], [rad/s] at the joint; empty: no reference, no feedback
  Matrix position, velocity;
  Matrix feedforward;   ///< motors x samples, in the quantity, held from its sample on
  bool linear = false;  ///< feed-forward is straight between samples instead
  /// quantity a rad, a rad/s of the motor's shaft; missing: 0
  std::map<std::string, double> kp, kd;
  /// no commands from the last sample on; else its pose is held without feed-forward
  bool relax_after_end = false;
  bool repeat_after_end = false;  ///< or with the last feed-forward
};

/// Encoders as the loop reads them.
struct LoopSensors {
  double resolution = 0.0;      ///< of an encoder, at the motor's shaft [rad]; 0: exact
  double position_noise = 0.0;  ///< [rad]
  double rate_noise = 0.0;      ///< of the tachometer [rad/s]
  std::uint64_t seed = 0;
};

}  // namespace jaculus::testbed
