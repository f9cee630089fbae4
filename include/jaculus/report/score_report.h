#pragma once
// The report of a score on sealed cases: confusion, calibration, accuracy against strength and effect, baselines.

#include "jaculus/evaluation/score.h"
#include "jaculus/report/report.h"

namespace jaculus {

Report score_report(const Score& score);

}  // namespace jaculus
