#pragma once
// What reports of single kinds of studies have of their own.

#include "jaculus/report/report.h"
#include "jaculus/studies/study.h"

namespace jaculus {

/// Torque against speed: points and fits, with the source's fit where a reference gives one (Fig. 5 of Norby et al. 2021).
Chart drag_bench_chart(const StudyResult& study);

/// The Pareto front, and the tail that its points choose, drawn to scale.
void add_tail_design(const StudyResult& study, Section& section);

}  // namespace jaculus
