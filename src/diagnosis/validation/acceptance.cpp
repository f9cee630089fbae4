#include "diagnosis/validation/acceptance.h"

namespace jaculus::diagnosis {

bool further_effects_predict(HeldOutGaps& gaps, const Posterior& posterior, const ModelFit& model,
                             const Settings& settings) {
  const ModelFit* evident = posterior.most_evident();
  if (evident->candidates.size() <= model.candidates.size()) return false;

  const HeldOut &own = gaps.of(model), &more = gaps.of(*evident);
  return own.valid && more.valid && own.after > settings.form_gap &&
         more.after < settings.further_effect * own.after;
}

AcceptedPosterior accepted_posterior(const SearchResult& search, HeldOutGaps& gaps,
                                     const Settings& settings) {
  AcceptedPosterior accepted{posterior_of(search, settings)};
  const ModelFit* leading = accepted.posterior.leading();
  if (leading == nullptr || !further_effects_predict(gaps, accepted.posterior, *leading, settings))
    return accepted;

  Settings in_full = settings;
  in_full.form_member = 0.0;
  return {posterior_of(search, in_full), true};
}

const ModelFit* without_idle_members(const Posterior& posterior, HeldOutGaps& gaps,
                                     const ModelFit* model, const Settings& settings) {
  while (model->candidates.size() > 1 && gaps.of(*model).valid) {
    const ModelFit* best = nullptr;
    for (const int dropped : model->candidates) {
      std::vector<int> rest = model->candidates;
      std::erase(rest, dropped);
      const ModelFit* less = posterior.find(rest);
      if (less == nullptr || !gaps.of(*less).valid) continue;
      if (best == nullptr || gaps.of(*less).log_gain > gaps.of(*best).log_gain) best = less;
    }

    if (best == nullptr) break;
    if (gaps.of(*model).log_gain - gaps.of(*best).log_gain > settings.worth) break;
    model = best;
  }
  return model;
}

}  // namespace jaculus::diagnosis
