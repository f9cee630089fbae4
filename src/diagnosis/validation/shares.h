#pragma once
// What each effect of a set explains of the held-out gap's energy.
//
//   v(S) = 1 - (after_S^2 - 1)/(before^2 - 1),  v(0): of the tolerances of N alone,
// gaps in noise floors (held_out.h). A set S is fitted on the training folds alone, unknown gains
// with it, all other effects at nominal and tolerances as all data have them for N. A share is of
// the effect's own part: what tolerances of its quantity do (tolerance_part.h) counts in v(0). For
// an effect i of the set N that is named, n = |N|:
//   alone    v({i}) - v(0)           what it explains if no other effect is granted
//   last     v(N) - v(N without i)   what is lost where it is dropped and the others are refitted
//   shapley  sum over S in N without i of |S|! (n - |S| - 1)!/n! (v(S and i) - v(S)),
// the mean over all orders in which the effects may join (Shapley 1953); these sum to v(N) - v(0).
// Where alone exceeds last, others can take its place; where last exceeds alone, it shows only
// beside others. Shares are not clipped: an effect may be worse than none. Errors of a sum of
// effects are no sum of errors, so that neither alone nor last need to sum to v(N) - v(0).
//
// Interval of shapley: Student's t over the folds, whose v is taken by fold. Nothing is stated
// where before < settings.plain_gap, a share of which is noise over noise.

#include <optional>
#include <vector>

#include "diagnosis/validation/held_out.h"

namespace jaculus::diagnosis {

/// Shares of a model's effects, in the order of its candidates; nothing for an effect of which a
/// subset can't be judged. Shapley's is stated of sets of at most three.
std::vector<std::optional<EffectShare>> shares_of(HeldOutGaps& gaps, const ModelFit& model);

}  // namespace jaculus::diagnosis
