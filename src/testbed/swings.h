#pragma once
// Smooth commands, the same for a robot whenever it is asked: sums of three sines under a window
// that begins and ends at nothing; and what a joint carries, to which they are relative.

#include <string>

#include "jaculus/core/types.h"
#include "jaculus/testbed/trials.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// What hangs on a joint, held still in the robot's rest pose. Of a pair: on one side.
struct Load {
  double hold = 0.0;     ///< torque at the joint against gravity [N m]
  double weight = 0.0;   ///< the most that gravity takes, over all angles of the joint [N m]
  double inertia = 0.0;  ///< about the joint, the rotor's behind its gear with it [kg m^2]
};

Load load_of(const RobotFiles& files, const std::string& planar);

/// A swing of about 1 at most over `time` (from 0 to its end), of joint number `joint`: a window
/// sin^2 times the mean of three sines, of 1.2, 2.6 and 4.4 turns over the time for the first
/// joint, a seventh more for each further one; and its rate [1/s].
struct Swing {
  Vector value, rate;
};

Swing swing_of(const Vector& time, int joint);

/// Whether a robot can do swing() with an input, leg_drop() and leg_bench().
bool can_swing(const RobotFiles& files, SwingInput input);
bool can_swing_legs(const RobotFiles& files);

}  // namespace jaculus::testbed
