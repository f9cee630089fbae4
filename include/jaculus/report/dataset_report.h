#pragma once
// The report of a dataset, simulated or imported: the robot in motion and every channel over time,
// what was commanded beside it.

#include "jaculus/model/planar.h"
#include "jaculus/report/report.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::report {

/// `model` is the dataset's robot, its overrides applied.
Report dataset_report(const trajectory::Dataset& dataset, const model::PlanarModel& model,
                      const std::string& title);

}  // namespace jaculus::report
