#pragma once
// Parts of the report of a diagnosis.

#include <vector>

#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/report/report.h"

namespace jaculus {

/// Measured and predicted rows of all conditions: by the nominal model and by the most probable one.
struct PredictedRows {
  std::vector<Vector> nominal;  ///< a condition each; empty where the simulation failed
  std::vector<Vector> best;     ///< likewise
};
PredictedRows predicted(const Diagnosis& diagnosis);

/// Every channel of a condition over time: trials, models, noise band.
std::vector<Chart> channel_charts(const Diagnosis& diagnosis, const PredictedRows& rows, std::size_t condition);

/// The first trial of a condition (solid) over what the most probable model predicts of it (ghost); no panels where nothing can be drawn.
Animation overlay(const Diagnosis& diagnosis, const PredictedRows& rows);

/// The robot with each component coloured by its share of the gap.
Drawing body_picture(const PlanarModel& model, const std::vector<ComponentShare>& shares);

}  // namespace jaculus
