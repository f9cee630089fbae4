#pragma once
// Parts that are built onto the robot, as MJCF: a payload, a battery that came loose, a load that
// slides along the last link, the mount of a fixed base.

#include <string>

#include "jaculus/testbed/changes.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// Bodies on the base's link.
std::string additions_to_base(const Changes& changes);

/// Link that a sliding load is part of: the last one that a motor moves, -1 where legs or tails are
/// all that is moved.
int loaded_link(const RobotFiles& files);
/// Body on that link: on a spring of 15 rad/s from the link's centre of mass, along the line from
/// its joint to there, or along the joint where that slides; damped to a tenth of critical.
std::string load_on_link(const RobotFiles& files, const Changes& changes);

/// Mass of a fixed base's mount: as much as the robot has [kg].
double mount_mass(const RobotFiles& files);
/// The mount's body, which holds the base's and is left open: slides along x on a spring, damped to
/// a twentieth of critical with the robot on it.
std::string mount_below(const RobotFiles& files, const Changes& changes);

}  // namespace jaculus::testbed
