#pragma once
// The report of a solved problem: the leap, velocity and acceleration, torque and voltage against
// their limits, the authors' figures, verification, how the solver went. And what `jaculus solve`
// prints of it.

#include <string>

#include "jaculus/model/planar.h"
#include "jaculus/report/report.h"
#include "jaculus/solver/plan_files.h"
#include "jaculus/solver/summary.h"
#include "jaculus/transcription/problem.h"

namespace jaculus::report {

/// A solved problem and what it left.
struct PlanRecord {
  solver::Summary summary;
  model::PlanarModel model;   ///< overrides applied, nothing locked
  double friction = kNaN;     ///< that the plan may use [-]
  solver::PlanTables tables;  ///< its motion and its iterations
};

/// `model` is the robot with the problem's overrides, nothing locked.
PlanRecord plan_record(const transcription::Problem& problem, const model::PlanarModel& model,
                       const solver::Summary& summary, const solver::PlanTables& tables);

Report solve_report(const PlanRecord& plan);

/// The summary for people. `colour` allows terminal colours.
std::string summary_text(const solver::Summary& summary, bool colour);

}  // namespace jaculus::report
