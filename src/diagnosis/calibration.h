#pragma once
// Probabilities as stated. The posterior of selection.h knows noise and starts, not what the plant itself gets wrong, so it is nearly
// always sure. How often verdicts are right was counted on cases of the testbed that no score of these rules rests on: all 120 of seed
// 303 (60 singles, 24 none, 16 pairs, 20 outside), and 96 of the second sealed batch of 2026-11-21 (results/), the ones it had got wrong
// among them. An effect is contested where the gap is under 1.5 noise floors, where more than that is left, where another of the four
// leading models leaves less than 1.1 times as much on held-out data, or where held-out data could not be judged.
//   verdict                right           stated
//   effect, not contested  28 of 28         0.97
//   effect, contested       9 of 14         0.60
//   several                22 of 25         0.75
//   ambiguous              11 of 14         0.70
//   none                   33 of 44         0.80   (three quarters of the cases that got it wrong before are in the count)
//   unexplained            33 of 39         0.75
//   rows of the ranking that the verdict states     p = w x (their part of the stated rows' posterior)
//   the others share 1 - w: unexplained, none, and the remaining effects by rank of their evidence, each half of the one before.
// An effect's own probability is that of the stated rows that it is part of.

#include "jaculus/diagnosis/diagnose.h"

namespace jaculus {

/// Rewrites the probabilities of out.effects and out.ranking. The ranking then sums to 1; its order by evidence among the unstated
/// stays.
void calibrate(Diagnosis& out);

}  // namespace jaculus
