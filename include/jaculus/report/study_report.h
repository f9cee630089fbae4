#pragma once
// The report of studies: their plots with the source's figures marked, the source's figures beside the computed ones, all rows.

#include <vector>

#include "jaculus/report/report.h"
#include "jaculus/studies/study.h"

namespace jaculus {

/// One section a study. Not empty.
Report study_report(const std::vector<StudyResult>& studies);

/// A column's name as an axis: "tail_inertia_kg_m2" is "tail inertia" in "kg m²".
ChartAxis column_axis(const std::string& column);

}  // namespace jaculus
