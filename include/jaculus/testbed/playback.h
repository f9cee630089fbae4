#pragma once
// Plays commands on the MuJoCo robot: a sampled loop with zero-order hold, motors with winding,
// back-EMF and limits, a battery, air, and whatever was changed about the robot.
//
//   command  = feed-forward(t_k) + kp (reference - encoder) + kd (reference rate - tachometer),
//     t_k = k/rate; motor shaft angles
//   Before the first command arrives the robot stands still, held as whoever placed it holds it.
//   torque:  the driver asks for the current i = a tau + c tau^3 (as it believes) and gets what
//            battery and limits leave
//   duty:    V = duty V_bus;   voltage: V, at most V_bus
//   current  i = (V - k_t w)/R within +-limit;
//     torque before the gear: the root of a tau + c tau^3 = i, within its limit
//   battery  V_bus = V_0 - R_b sum(V i)/V_bus over all motors (a driver draws the motor's power)
//   winding  T' = heat i^2 R,  R = R_0 (1 + 0.0039 T),  k_t = k_t0 (1 - 0.001 T)
// Motors and air after Norby et al. 2021, equations 1 and 5 to 8; temperature coefficients of
// copper and of NdFeB magnets.

#include <map>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/testbed/changes.h"
#include "jaculus/testbed/motor_commands.h"

namespace jaculus::testbed {

struct RobotFiles;
struct Numerics;

struct PlayOptions {
  double duration = 0.0;  ///< [s]
  bool floor = true;
  bool base_fixed = false;
  bool stops = false;  ///< whether joints' ranges are stops that they meet
  /// x, z, pitch, joints [m, rad]; without z the feet stand on the floor
  std::map<std::string, double> start;
  bool level = false;  ///< turns the base until front and rear feet stand
  LoopSensors sensors;
};

/// What happened, at every step. Motors are those in space; `motor_of` names their planar joints.
struct Recording {
  bool diverged = false;
  double end_time = 0.0;
  Vector time;
  Matrix base, base_rate;  ///< x, z, pitch x samples
  std::vector<std::string> motors, motor_of;
  Matrix position, velocity;      ///< joint angle on the motor's side [rad], [rad/s]
  Matrix torque;                  ///< at the joint [N m]
  Matrix current, voltage, duty;  ///< of one motor [A], [V], [-]
  Vector bus_voltage;             ///< [V]
  Matrix foot_force;              ///< z of each toe [N]
  std::vector<std::string> toes;
};

/// Plays. A robot that MuJoCo loses (not finite) ends the recording and is marked.
Recording play(const RobotFiles& files, const Changes& changes, const Commands& commands,
               const PlayOptions& options, const Numerics& numerics);

/// Rows of a recording at given times: cubic Hermite of value and rate, held before the start [unit
/// of `value`].
Vector sample(const Vector& time, const Vector& value, const Vector& rate, const Vector& at);
/// Linear, for quantities without a rate.
Vector sample(const Vector& time, const Vector& value, const Vector& at);

}  // namespace jaculus::testbed
