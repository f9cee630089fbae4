#pragma once
// Parts of the report of a diagnosis.

#include <vector>

#include "jaculus/diagnosis/diagnose.h"
#include "report/document/document.h"

namespace jaculus::report {

/// Measured and predicted rows of all datasets, a dataset each [units of the rows].
struct PredictedRows {
  std::vector<Vector> measured;
  std::vector<Vector> nominal;                   ///< empty where the simulation failed
  std::vector<Vector> best;                      ///< by the model found, likewise
  std::vector<std::vector<double>> noise_floor;  ///< a channel each; NaN where nothing tells it
};
PredictedRows predicted(const diagnosis::Diagnosis& diagnosis);

/// Every channel of a dataset over time: trials, models, noise band.
std::vector<Chart> channel_charts(const diagnosis::Diagnosis& diagnosis, const PredictedRows& rows,
                                  std::size_t dataset);

/// The first trial of a dataset (solid) over what the most probable model predicts of it (ghost);
/// no panels where nothing can be drawn.
Animation overlay(const diagnosis::Diagnosis& diagnosis, const PredictedRows& rows);

/// The robot with each component coloured by its share of the gap.
Drawing body_picture(const model::PlanarModel& model,
                     const std::vector<diagnosis::ComponentShare>& shares);

}  // namespace jaculus::report
