#pragma once
// Logged values that the robot can't reach: another unit, a column of another joint. Told by the
// robot's limits alone, before anything is simulated.
//
// Of each channel of a joint with a motor, over all trials, the size that one sample in a hundred
// passes, and three at least, beside what the motor gives at most:
//   torque, motor torque, current, voltage, duty   by the driver's limits and by the bus voltage at
//                                                  rest (components/motor.h);
//   rate, and spans of 0.05 s of a position        the rate without load, V/(G k_t), or the stated
//                                                  speed limit;
//   a position's span                              the joint's range.
// More than twice as much is told, for no sensor's scale is off by so much. A unit that is wrong
// shows only where the values are large beside the limit. What a motor gives whose limits are not
// stated is not known, and nothing is said of it.

#include <string>
#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::simulation {

struct OutOfReach {
  std::string text;  ///< one sentence, with the channel
  /// Whether no such robot could do it. False of limits that are stated and nothing holds: a
  /// planned speed limit of an ideal motor, a range without a stop.
  bool impossible = true;
};

/// By streams and channels in the order of their names. `model`: with the dataset's bus voltage
/// (dataset_plant).
std::vector<OutOfReach> values_out_of_reach(const trajectory::Dataset& dataset,
                                            const model::PlanarModel& model);

}  // namespace jaculus::simulation
