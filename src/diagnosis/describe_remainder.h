#pragma once
// The remainder of a diagnosis: events and what the missing forces follow, about the model that is
// stated.

#include <vector>

#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/diagnosis/options.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::diagnosis {

/// Adds to a diagnosis what its model leaves: the share of the gap, and under logged inputs events
/// and the places of missing forces, sought over all of every trial.
void describe_remainder(const std::vector<trajectory::Dataset>& datasets,
                        const DiagnoseOptions& options, Diagnosis& found);

}  // namespace jaculus::diagnosis
