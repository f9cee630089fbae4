#pragma once
// What reports of single kinds of studies have of their own.

#include "jaculus/studies/study.h"
#include "report/document/document.h"

namespace jaculus::report {

/// A column's name as an axis: "tail_inertia_kg_m2" is "tail inertia" in "kg m²".
ChartAxis column_axis(const std::string& column);

/// Torque against speed: points and fits, with the source's fit where a reference gives one (Fig. 5
/// of Norby et al. 2021).
Chart drag_bench_chart(const studies::StudyResult& study);

/// The Pareto front, and the tail that its points choose, drawn to scale.
void add_tail_design(const studies::StudyResult& study, Section& section);

}  // namespace jaculus::report
