#pragma once
// Probabilities as stated. The posterior of selection.h knows noise and starts, not what the plant itself gets wrong, so it is nearly
// always sure. How often verdicts are right was counted on cases of the testbed made for nothing else (seed 303; 60 singles, 24 none,
// 16 pairs, 20 outside): effect 49 of 50, several 8 of 10, ambiguous 6 of 8, none 24 of 29, unexplained 18 of 23. That share w, a
// little less where it is all but one, is what a verdict may claim.
//   rows of the ranking that the verdict states     p = w x (their part of the stated rows' posterior)
//   the others share 1 - w: unexplained, none, and the remaining effects by rank of their evidence, each half of the one before.

#include "jaculus/diagnosis/diagnose.h"

namespace jaculus {

/// Rewrites the probabilities of out.effects and out.ranking. The ranking then sums to 1; its order by evidence among the unstated
/// stays.
void calibrate(Diagnosis& out);

}  // namespace jaculus
