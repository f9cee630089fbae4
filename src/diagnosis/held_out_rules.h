#pragma once
// What held-out data say of a selection. Log evidence knows noise and starts, but not what the plant's own form gets wrong: a second
// effect may merely bend to that. Data that the fit never saw tell.

#include <map>
#include <vector>

#include "diagnosis/posterior.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/held_out.h"

namespace jaculus {

/// Held-out gaps of models, each worked out once.
class HeldOutGaps {
 public:
  HeldOutGaps(const DiagnosisProblem& problem, const Linearisation& about, const Fit& none)
      : problem_(problem), about_(about), none_(none) {}

  const HeldOut& of(const ModelFit& model);

 private:
  const DiagnosisProblem& problem_;
  const Linearisation& about_;
  Fit none_;
  std::map<std::vector<int>, HeldOut> gaps_;
};

/// Whether held-out data ask for more effects than a model has: it leaves more than 1.2 noise floors, and the most evident model, which has
/// more effects, less than 0.6 of that.
bool asks_for_more(HeldOutGaps& gaps, const Selection& selection, const ModelFit& model);

/// Weighs the models anew with every effect beyond the first in full, whatever the form of the first may hide, where held-out data ask for
/// more than the leading model has. Whether they do.
bool heed_held_out(HeldOutGaps& gaps, Selection& selection);

/// The model without those members of a set without which held-out data are predicted as well, the least missed first. Only sets that were
/// fitted and judged can take its place.
const ModelFit* prune(const Selection& selection, HeldOutGaps& gaps, const ModelFit* model);

/// A verdict that names effects must predict: where they don't predict held-out data better than the nominal model does, there is no gap to
/// explain (below 1.5 noise floors) or one that the catalogue does not explain. Changes verdict, effects and reasons.
void demand_prediction(Diagnosis& out);

}  // namespace jaculus
