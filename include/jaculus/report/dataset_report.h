#pragma once
// The report of a dataset, simulated or imported: the robot in motion and every channel over time,
// what was commanded beside it.

#include <nlohmann/json.hpp>
#include <string>

#include "jaculus/model/planar.h"
#include "jaculus/report/report.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::report {

/// `model` is the dataset's robot, its overrides applied.
Report dataset_report(const trajectory::Dataset& dataset, const model::PlanarModel& model,
                      const std::string& title);

/// Trials for people. `summary` as of effects::simulate_trials().
std::string simulation_text(const simulation::Experiment& experiment,
                            const nlohmann::ordered_json& summary);

}  // namespace jaculus::report
