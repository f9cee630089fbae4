#pragma once
// The report of a score on blinded cases: confusion, calibration, accuracy against strength and
// effect, baselines.

#include "jaculus/evaluation/score.h"
#include "jaculus/report/report.h"

namespace jaculus::report {

Report score_report(const evaluation::Score& score);

}  // namespace jaculus::report
