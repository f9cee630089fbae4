#pragma once
// The remainder of a diagnosis: events and what the missing forces follow, about the model that is
// stated.

#include <vector>

#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/diagnosis/options.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::diagnosis {

/// Adds to a diagnosis what its model leaves: the share of the gap, under logged inputs events, and
/// the places of missing forces where every motor's torque is logged and nothing touches the
/// ground, both sought over all of every trial. Under a plan or a script the logged torques drive
/// the model then: a fault between command and log is none of the forces that are missing. Where
/// that finds no pattern or can't be had, and a plan or script drives the robot, patterns are
/// sought by simulation of the whole motion (motion_patterns.h).
void describe_remainder(const std::vector<trajectory::Dataset>& datasets,
                        const DiagnoseOptions& options, Diagnosis& found);

}  // namespace jaculus::diagnosis
