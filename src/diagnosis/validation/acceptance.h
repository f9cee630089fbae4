#pragma once
// What held-out data say of a posterior. Log evidence knows noise and starts, but not what the
// plant's own form gets wrong: a second effect may merely bend to that. Data that the fit never saw
// tell.

#include "diagnosis/validation/held_out.h"

namespace jaculus::diagnosis {

/// Whether held-out data ask for more effects than a model has: it leaves more than
/// settings.form_gap, and the most evident model, which has more effects, less than
/// settings.further_effect of that.
bool further_effects_predict(HeldOutGaps& gaps, const Posterior& posterior, const ModelFit& model,
                             const Settings& settings);

/// The posterior that held-out data leave standing.
struct AcceptedPosterior {
  Posterior posterior;
  bool without_form = false;  ///< every effect beyond the first counts in full
};
/// Every effect beyond the first counts in full, whatever the form of the first may hide, where
/// held-out data ask for more than the leading model has.
AcceptedPosterior accepted_posterior(const SearchResult& search, HeldOutGaps& gaps,
                                     const Settings& settings);

/// The model without those members without which held-out data are predicted as well, the least
/// missed first. Only sets that were fitted and can be judged take its place.
const ModelFit* without_idle_members(const Posterior& posterior, HeldOutGaps& gaps,
                                     const ModelFit* model, const Settings& settings);

}  // namespace jaculus::diagnosis
