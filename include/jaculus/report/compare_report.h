#pragma once
// The report of several solved problems side by side, and what `jaculus compare` prints of them.

#include <string>
#include <vector>

#include "jaculus/report/plan_report.h"
#include "jaculus/report/report.h"
#include "jaculus/studies/comparison.h"

namespace jaculus::report {

/// `rows` are those of the comparison, one a plan.
Report compare_report(const std::vector<PlanRecord>& plans,
                      const std::vector<studies::ComparisonRow>& rows);

/// The comparison for people. `colour` allows terminal colours.
std::string comparison_text(const std::vector<studies::ComparisonRow>& rows, bool colour);

}  // namespace jaculus::report
