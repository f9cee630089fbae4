#pragma once
// Logged values that the robot can't reach: another unit, a sum in place of a joint's own, a column
// of another joint. Told by the robot's limits alone, before anything is simulated.
//
// Of each channel of a joint with a motor, over all trials, the size that one sample in a hundred
// passes, beside what the motor gives at most:
//   torque, motor torque, current, voltage, duty   by the driver's limits and by the bus voltage at
//                                                  rest (components/motor.h);
//   rate, and spans of 0.05 s of a position        the rate without load, V/(G k_t), or the stated
//                                                  speed limit;
//   a position's span                              the joint's range.
// Twice as much is told: no sensor's scale is off by so much, every wrong unit is. What a motor
// whose limits are not stated gives is not known, and nothing is said of it.

#include <string>
#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::simulation {

/// One sentence for each channel, by streams and channels in the order of their names. `model`:
/// with the dataset's bus voltage (dataset_plant).
std::vector<std::string> values_out_of_reach(const trajectory::Dataset& dataset,
                                             const model::PlanarModel& model);

}  // namespace jaculus::simulation
