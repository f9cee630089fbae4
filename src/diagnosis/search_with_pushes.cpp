#include "diagnosis/search_with_pushes.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/selection/push_scan.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kOfIt = 0.5;     ///< share of a push that every trial has at least
constexpr double kSure = 3.0;     ///< deviations
constexpr double kInside = 1.01;  ///< a length so near its bound is at it

Selection selected(const Prepared& prepared, const ProblemBuilder& rebuild,
                   const DiagnoseOptions& options) {
  const Problem& problem = *prepared.built.problem;
  const int most = problem.settings.search_windows;
  Comparison comparison = first_comparison(problem, prepared.noise);
  // A second search pays where the first is on half of the windows at most.
  if (prepared.built.forward && in_windows(problem) &&
      windows_of(problem.observations) >= 2 * most) {
    const BuiltProblem part = rebuild(with_windows(problem.observations, most));
    const Hypotheses& all = problem.hypotheses;
    const bool same = part.problem->hypotheses.parameters.size() == all.parameters.size();
    NoiseModel noise = estimate_noise(*part.problem, part.problem->hypotheses.nominal());
    if (same && noise.valid()) {
      Selection found = select_models(
          *part.problem, first_comparison(*part.problem, std::move(noise)), options.progress);
      if (!found.search.models.empty())
        return select_models_from(problem, std::move(comparison), std::move(found.search),
                                  options.progress);
    }
  }
  return select_models(problem, std::move(comparison), options.progress);
}

/// The most probable of all models, none among them.
const ModelFit& leading(const SearchResult& search) {
  return *std::max_element(
      search.models.begin(), search.models.end(),
      [](const ModelFit& a, const ModelFit& b) { return a.log_weight() < b.log_weight(); });
}

/// Whether the leading model leaves more, or needs several effects: one push may be what these
/// stand in for, however little they leave.
bool pushes_sought(const Prepared& prepared, const Selection& selection) {
  const Problem& problem = *prepared.built.problem;
  if (!prepared.built.forward || problem.settings.pushes_tried == 0 || in_windows(problem) ||
      problem.observations.datasets.size() != 1 || selection.search.models.empty())
    return false;
  const ModelFit& lead = leading(selection.search);
  return lead.candidates.size() > 1 || leaves_more(problem, lead.fit);
}

/// Adds pushes, of each coordinate the one that gains more.
void add_pushes(const std::vector<LikelyPush>& more, std::vector<LikelyPush>& pushes) {
  for (const LikelyPush& push : more) {
    const auto same = std::find_if(pushes.begin(), pushes.end(), [&](const LikelyPush& p) {
      return p.coordinate == push.coordinate;
    });
    if (same == pushes.end())
      pushes.push_back(push);
    else if (push.gain > same->gain)
      *same = push;
  }
}

/// The space about the model without effects, as the search had it or worked out here; nothing
/// where that model can't be fitted.
std::optional<Relinearised> about_no_effect(const Prepared& prepared, const Selection& found) {
  if (found.about_none) return found.about_none;
  const Problem& problem = *prepared.built.problem;
  Comparison comparison = first_comparison(problem, prepared.noise);
  const Fit none = fit_model(problem, comparison.whitening, problem.hypotheses.nuisances(),
                             {comparison.noise.p});
  if (!none.valid) return {};
  return relinearise(problem, std::move(comparison), none);
}

/// Pushes that may have acted, as effects: about the model without effects, for a push may be what
/// makes an effect lead, and about the leading one, without whose effects their own misfit would
/// look like pushes.
std::vector<effects::Effect> likely_push_effects(const Prepared& prepared,
                                                 const Selection& effects_alone,
                                                 const DiagnoseOptions& options) {
  const Problem& problem = *prepared.built.problem;
  DiagnoseOptions narrow = options;
  narrow.settings.force_box = scanned_box(problem);
  const BuiltProblem scanned = builder_of(narrow)(problem.observations);
  const int most = problem.settings.pushes_tried;

  std::vector<LikelyPush> likely;
  const ModelFit& leader = leading(effects_alone.search);
  if (!leader.candidates.empty())
    likely = likely_pushes(problem, *scanned.problem, effects_alone.comparison, leader.fit, most);
  if (const auto about = about_no_effect(prepared, effects_alone))
    add_pushes(likely_pushes(problem, *scanned.problem, about->comparison, about->fit, most),
               likely);

  std::vector<effects::Effect> pushes;
  const double duration = problem.observations.datasets.front().window_end;
  for (const LikelyPush& push : likely) pushes.push_back(push_effect(problem, push, duration));
  return pushes;
}

/// The effects that a search found worth a fit.
std::vector<effects::Effect> fitted_effects(const Problem& problem, const SearchResult& search) {
  std::set<int> fitted;
  for (const ModelFit& model : search.models)
    fitted.insert(model.candidates.begin(), model.candidates.end());
  std::vector<effects::Effect> effects;
  for (const int c : fitted) effects.push_back(*problem.hypotheses.candidates[c].effect);
  return effects;
}

/// The same data with these effects as candidates.
Prepared with_effects(const Prepared& prepared, std::vector<effects::Effect> effects) {
  const Problem& problem = *prepared.built.problem;
  Prepared out = prepared;
  out.built = builder_of(std::move(effects), problem.settings)(problem.observations);
  out.noise = estimate_noise(*out.built.problem, out.built.problem->hypotheses.nominal(),
                             prepared.noise.alignments);
  return out;
}

/// Whether every trial has half of a fitted push or more, as far as its noise lets that be told:
/// with j the slopes of a trial's rows by the peak u and r its residual, the trial's own peak is
/// u - j.r/j.j, of deviation 1/|j|.
bool in_every_trial(const Whitening& whitening, const Fit& fit, Eigen::Index peak, double u) {
  for (const SegmentBlock& trial : whitening.datasets.front().blocks) {
    const auto slopes = fit.jacobian.col(peak).segment(trial.first, trial.count);
    const double energy = slopes.squaredNorm();
    if (!(energy > 0.0)) continue;
    const double own = u - slopes.dot(fit.residual.segment(trial.first, trial.count)) / energy;
    const double unsure = kSure / (std::sqrt(energy) * std::abs(u));
    if (own / u < kOfIt - unsure) return false;
  }
  return true;
}

/// Whether a model has a push that every trial had, of a length within its bounds. One alone:
/// forces that come at the same times in every trial of the same plan are told from forces that
/// follow the motion by nothing but how few there are, and with several any missing force can be
/// drawn.
bool has_one_push(const Problem& problem, const Whitening& whitening, const ModelFit& model) {
  int pushes = 0;
  for (const int c : model.candidates) {
    const Candidate& candidate = problem.hypotheses.candidates[c];
    if (!candidate.is_event()) continue;
    ++pushes;
    const int peak = candidate.parameters.front(), length = candidate.parameters.back();
    const FreeParameter& own = problem.hypotheses.parameters[length];
    const double value = model.fit.p[length];
    if (value <= own.bounds.lower * kInside || value >= own.bounds.upper / kInside) return false;
    const double u = model.fit.p[peak] / problem.hypotheses.parameters[peak].scale;
    if (!in_every_trial(whitening, model.fit, index_of(model.fit.free, peak), u)) return false;
  }
  return pushes == 1;
}

/// By how much the most probable model leads none [log weight].
double lead_over_none(const SearchResult& search) {
  return leading(search).log_weight() - search.models.front().log_weight();
}

/// By how much it leads the most probable one without a push [log weight].
double lead_of_push(const Problem& problem, const SearchResult& search) {
  double without = -kInfinity;
  for (const ModelFit& model : search.models) {
    if (!problem.hypotheses.has_event(model.candidates))
      without = std::max(without, model.log_weight());
  }
  return leading(search).log_weight() - without;
}

/// Effects of the leading model, pushes left out.
int effects_of_leading(const Problem& problem, const SearchResult& search) {
  const std::vector<int>& members = leading(search).candidates;
  return static_cast<int>(std::count_if(members.begin(), members.end(), [&](int c) {
    return !problem.hypotheses.candidates[c].is_event();
  }));
}

/// Whether a push takes the place of effects, and clearly leads the best model without one.
bool is_simpler(const Problem& with, const SearchResult& with_pushes,
                const SearchResult& effects_alone) {
  return effects_of_leading(with, with_pushes) < count_of(leading(effects_alone).candidates) &&
         lead_of_push(with, with_pushes) > with.settings.clear_lead;
}

}  // namespace

bool push_established(const Problem& problem, const SearchResult& with_pushes,
                      const SearchResult& effects_alone) {
  const Settings& settings = problem.settings;
  if (!lacks(problem, leading(with_pushes).fit)) return true;
  return lead_over_none(effects_alone) < settings.bare_mention &&
         lead_of_push(problem, with_pushes) > settings.clear_lead;
}

Searched search_with_pushes(Prepared prepared, const ProblemBuilder& rebuild,
                            const DiagnoseOptions& options) {
  if (!prepared.reasons.empty()) return {std::move(prepared), {}};
  Selection effects_alone = selected(prepared, rebuild, options);
  if (!pushes_sought(prepared, effects_alone))
    return {std::move(prepared), std::move(effects_alone)};

  if (options.progress) options.progress("pushes");
  const std::vector<effects::Effect> pushes = likely_push_effects(prepared, effects_alone, options);
  if (pushes.empty()) return {std::move(prepared), std::move(effects_alone)};
  std::vector<effects::Effect> effects =
      fitted_effects(*prepared.built.problem, effects_alone.search);
  effects.insert(effects.end(), pushes.begin(), pushes.end());
  Prepared with = with_effects(prepared, std::move(effects));
  Selection again = selected(with, rebuild, options);
  if (again.search.models.empty() ||
      !has_one_push(*with.built.problem, again.comparison.whitening, leading(again.search)) ||
      !push_established(*with.built.problem, again.search, effects_alone.search) ||
      !(leaves_more(*prepared.built.problem, leading(effects_alone.search).fit) ||
        is_simpler(*with.built.problem, again.search, effects_alone.search)))
    return {std::move(prepared), std::move(effects_alone)};
  return {std::move(with), std::move(again)};
}

}  // namespace jaculus::diagnosis
