#pragma once
// The report of solved problems: the leaps side by side, velocity and acceleration, torque and voltage against their limits, the
// authors' figures, verification, how the solver went.

#include <vector>

#include "jaculus/report/compare_report.h"
#include "jaculus/report/report.h"
#include "jaculus/report/summary.h"
#include "jaculus/solver/result.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus {

/// A solved problem and what it wrote.
struct PlanRecord {
  Summary summary;
  PlanarModel model;       ///< overrides applied, nothing locked
  double friction = kNaN;  ///< that the plan may use [-]
  Table plan;              ///< plan.csv; no columns where there is no plan
  Table history;           ///< iterations.csv; no columns where there is none
};

/// Report of one plan.
Report solve_report(const PlanRecord& plan);

/// Report of several; `rows` are those of the comparison, one a plan.
Report compare_report(const std::vector<PlanRecord>& plans, const std::vector<ComparisonRow>& rows);

/// iterations.csv: one row an iteration, without times, so that every run writes the same.
Table iteration_table(const std::vector<IterationInfo>& history);

}  // namespace jaculus
