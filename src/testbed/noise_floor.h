#pragma once
// How large a difference of two runs is beside the noise of the sensors that see it.

#include <string>

#include "jaculus/testbed/trials.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// Standard deviation of a channel's noise, a joint's channel being the mean of its encoders; NaN
/// for currents and the like, which drive the motion rather than show it.
double channel_floor(const std::string& channel, const std::string& unit, const SensorSpec& sensors,
                     const RobotFiles& robot);

/// |y[k+1] - 2 y[k] + y[k-1]|, the most at every sample or its two neighbours: where a run jumps (a
/// stop, a foot that lands), by how much.
Vector bends(const Vector& y);

/// Root-mean-square difference of two noise-free datasets of one spec, every channel over its noise
/// floor (more beside jumps, where samples tell a time), root mean square over channels of all
/// streams; scatter of the start pose is not part of the floor [-].
double gap(const trajectory::Dataset& a, const trajectory::Dataset& b, const SensorSpec& sensors,
           const RobotFiles& robot);

}  // namespace jaculus::testbed
