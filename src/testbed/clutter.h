#pragma once
// What a careful builder doesn't know about the robot: every stated number is off by a draw from
// its tolerance (model/tolerances.h). A cluttered robot is a healthy one.
//
// Off by the same: what is one part of a pair, for both sides come from one drawing and one batch.
// Off each by itself: encoders' zeros. A draw beyond two standard deviations is drawn again.
//
//   links      mass m -> m (1 + e), inertia likewise, centre of mass c -> c + (e, 0, e')
//   lengths    every point of a link (joints that hang on it, pins, feet) p -> p (1 + e)
//   motors     k_t and R -> (1 + e), dry friction |e| share of the largest torque at the joint
//   encoders   read q + e;   gains k -> k (1 + e);   floor mu -> mu (1 + e)

#include <cstdint>
#include <map>
#include <string>

#include "jaculus/model/tolerances.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// How far one motor is off.
struct MotorClutter {
  double torque_constant = 1.0;       ///< true over stated [-]
  double resistance = 1.0;            ///< true over stated [-]
  double friction = 0.0;              ///< dry, at the joint [N m]
  double gain_p = 1.0, gain_d = 1.0;  ///< true over stated [-]
  double current_scale = 1.0;         ///< logged over true [-]
};

/// How far one link is off.
struct LinkClutter {
  double mass = 1.0, inertia = 1.0;  ///< true over stated [-]
  double length = 1.0;               ///< of every point on it, true over stated [-]
  Vec2 com = Vec2::Zero();           ///< true minus stated, in the link's x-z plane [m]
};

/// A healthy robot that is not quite what its files say. Default-built: exactly that.
struct Clutter {
  std::map<std::string, LinkClutter> links;    ///< by link in space
  std::map<std::string, MotorClutter> motors;  ///< by the motor's planar name
  std::map<std::string, double>
      encoder_zero;             ///< by joint in space: reads the angle plus this [rad]
  double floor_friction = 1.0;  ///< true over stated [-]
};

/// Draws every deviation of a robot. Same seed: same clutter.
Clutter draw_clutter(const RobotFiles& files, const model::Tolerances& tolerances,
                     std::uint64_t seed);

/// The robot as it really is: bodies, pins, feet, floor, motors, encoders and gains of `files`,
/// off by `clutter`.
RobotFiles cluttered(const RobotFiles& files, const Clutter& clutter);

}  // namespace jaculus::testbed
