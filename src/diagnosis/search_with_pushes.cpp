#include "diagnosis/search_with_pushes.h"

#include <algorithm>

#include "diagnosis/selection/push_scan.h"

namespace jaculus::diagnosis {
namespace {

Selection selected(const Prepared& prepared, const DiagnoseOptions& options) {
  const Problem& problem = *prepared.built.problem;
  return select_models(problem, first_comparison(problem, prepared.noise), options.progress);
}

/// The most probable of all models, none among them.
const ModelFit& leading(const SearchResult& search) {
  return *std::max_element(
      search.models.begin(), search.models.end(),
      [](const ModelFit& a, const ModelFit& b) { return a.log_weight() < b.log_weight(); });
}

bool lacks_forces(const Fit& fit, const Settings& settings) {
  return fit.log_evidence - fit.log_complete >= settings.remainder_left;
}

bool pushes_sought(const Prepared& prepared, const Selection& selection) {
  const Problem& problem = *prepared.built.problem;
  return prepared.built.forward && problem.settings.pushes_tried > 0 && !in_windows(problem) &&
         problem.observations.datasets.size() == 1 && !selection.search.models.empty() &&
         lacks_forces(leading(selection.search).fit, problem.settings);
}

/// Pushes that may have acted, as effects; none where by linear algebra none is worth it.
std::vector<effects::Effect> likely_push_effects(const Prepared& prepared,
                                                 const DiagnoseOptions& options) {
  const Problem& problem = *prepared.built.problem;
  Comparison comparison = first_comparison(problem, prepared.noise);
  const Fit none = fit_model(problem, comparison.whitening, problem.hypotheses.nuisances(),
                             {comparison.noise.p});
  if (!none.valid) return {};
  const Relinearised about = relinearise(problem, std::move(comparison), none);

  DiagnoseOptions narrow = options;
  narrow.settings.force_box = scanned_box(problem);
  const BuiltProblem scanned = builder_of(narrow)(problem.observations);
  const std::vector<LikelyPush> likely = likely_pushes(problem, *scanned.problem, about.comparison,
                                                       about.fit, problem.settings.pushes_tried);
  if (likely.empty() || !(likely.front().gain > 0.0)) return {};

  std::vector<effects::Effect> pushes;
  const double duration = problem.observations.datasets.front().window_end;
  for (const LikelyPush& push : likely) pushes.push_back(push_effect(problem, push, duration));
  return pushes;
}

/// The same data with some effects more as candidates.
Prepared with_effects(const Prepared& prepared, std::vector<effects::Effect> more,
                      const DiagnoseOptions& options) {
  Prepared out = prepared;
  out.built = builder_of(options, std::move(more))(prepared.built.problem->observations);
  out.noise = estimate_noise(*out.built.problem, out.built.problem->hypotheses.nominal(),
                             prepared.noise.alignments);
  return out;
}

bool has_event(const Problem& problem, const ModelFit& model) {
  return std::any_of(model.candidates.begin(), model.candidates.end(), [&](int c) {
    const effects::Effect* effect = problem.hypotheses.candidates[c].effect;
    return effect != nullptr && effect->event;
  });
}

}  // namespace

Searched search_with_pushes(Prepared prepared, const DiagnoseOptions& options) {
  if (!prepared.reasons.empty()) return {std::move(prepared), {}};
  Selection effects_alone = selected(prepared, options);
  if (!pushes_sought(prepared, effects_alone))
    return {std::move(prepared), std::move(effects_alone)};

  if (options.progress) options.progress("pushes");
  std::vector<effects::Effect> pushes = likely_push_effects(prepared, options);
  if (pushes.empty()) return {std::move(prepared), std::move(effects_alone)};
  Prepared with = with_effects(prepared, std::move(pushes), options);
  Selection again = selected(with, options);
  if (again.search.models.empty() || !has_event(*with.built.problem, leading(again.search)))
    return {std::move(prepared), std::move(effects_alone)};
  return {std::move(with), std::move(again)};
}

}  // namespace jaculus::diagnosis
