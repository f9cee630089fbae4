#include "diagnosis/search_with_forces.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/pattern_scan.h"
#include "diagnosis/selection/push_scan.h"

namespace jaculus::diagnosis {
namespace {

/// Whether a set of effects has some of a kind.
using Kind = bool (Hypotheses::*)(const std::vector<int>&) const;

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

/// Whether the leading model leaves more, or needs several effects: one force that no effect is may
/// be what these stand in for, however little they leave.
bool forces_sought(const Prepared& prepared, const Selection& selection) {
  const Problem& problem = *prepared.built.problem;
  if (!prepared.built.forward || in_windows(problem) || problem.observations.datasets.size() != 1 ||
      selection.search.models.empty())
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
  if (problem.settings.pushes_tried == 0) return {};
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

/// Patterns as candidates, and of how many they are the likeliest.
struct CandidatePatterns {
  std::vector<PlacePattern> patterns;
  int tried = 0;
};

void add_patterns(const PatternScan& scan, CandidatePatterns& candidates) {
  candidates.tried = std::max(candidates.tried, scan.tried);
  for (const LikelyPattern& likely : scan.likely) {
    const bool known =
        std::any_of(candidates.patterns.begin(), candidates.patterns.end(),
                    [&](const PlacePattern& own) { return own.name == likely.pattern.name; });
    if (!known) candidates.patterns.push_back(likely.pattern);
  }
}

/// Forces of stated forms that may be at work: about the leading model, which may lack one, and about
/// the model without effects, for one may be what the effects stand in for.
CandidatePatterns candidate_patterns(const Prepared& prepared, const Selection& found) {
  const Problem& problem = *prepared.built.problem;
  CandidatePatterns patterns;
  if (problem.settings.patterns_tried == 0) return patterns;
  const std::vector<Alignment>& alignments = found.comparison.noise.alignments;
  const ModelFit& leader = leading(found.search);
  const ModelFit& none = found.search.models.front();
  add_patterns(likely_patterns({&problem, leader.candidates, leader.fit.p}, alignments), patterns);
  if (!leader.candidates.empty())
    add_patterns(likely_patterns({&problem, {}, none.fit.p}, alignments), patterns);
  return patterns;
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

/// By how much it leads the most probable one that has no push, or no pattern [log weight].
double lead_over_those_without(Kind kind, const Problem& problem, const SearchResult& search) {
  double without = -kInfinity;
  for (const ModelFit& model : search.models) {
    if (!(problem.hypotheses.*kind)(model.candidates))
      without = std::max(without, model.log_weight());
  }
  return leading(search).log_weight() - without;
}

double lead_of_push(const Problem& problem, const SearchResult& search) {
  return lead_over_those_without(&Hypotheses::has_event, problem, search);
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

/// Whether a model has a push or a pattern.
bool goes_beyond_effects(const Problem& problem, const ModelFit& model) {
  return problem.hypotheses.has_event(model.candidates) ||
         problem.hypotheses.has_pattern(model.candidates);
}

/// Whether the leading model has no push, or one that is established.
bool push_holds(const Problem& with, const Selection& again, const Problem& problem,
                const SearchResult& effects_alone) {
  const ModelFit& lead = leading(again.search);
  if (!with.hypotheses.has_event(lead.candidates)) return true;
  return has_one_push(with, again.comparison.whitening, lead) &&
         push_established(with, again.search, effects_alone) &&
         (leaves_more(problem, leading(effects_alone).fit) ||
          is_simpler(with, again.search, effects_alone));
}

}  // namespace

bool push_established(const Problem& problem, const SearchResult& with_pushes,
                      const SearchResult& effects_alone) {
  const Settings& settings = problem.settings;
  if (!lacks(problem, leading(with_pushes).fit)) return true;
  return lead_over_none(effects_alone) < settings.bare_mention &&
         lead_of_push(problem, with_pushes) > settings.clear_lead;
}

bool pattern_established(const Problem& problem, const SearchResult& search, int tried) {
  if (!problem.hypotheses.has_pattern(leading(search).candidates)) return true;
  const double lead = lead_over_those_without(&Hypotheses::has_pattern, problem, search);
  return lead > problem.settings.clear_lead + std::log(std::max(1, tried));
}

namespace {

/// Whether there were models of a kind, which are gone then.
bool left_out(Kind kind, const Problem& problem, SearchResult& search) {
  return std::erase_if(search.models, [&](const ModelFit& model) {
           return (problem.hypotheses.*kind)(model.candidates);
         }) > 0;
}

/// Pushes count where one leads that holds, patterns where some lead that are established. Else they
/// are left out as if they had been no candidates, and what leads then is asked in turn.
void leave_out_unfounded(const Problem& with, const Problem& problem,
                         const SearchResult& effects_alone, int tried, Selection& again) {
  const auto leads = [&](Kind kind) {
    return (with.hypotheses.*kind)(leading(again.search).candidates);
  };
  for (bool changed = true; changed;) {
    const bool push =
        leads(&Hypotheses::has_event) && push_holds(with, again, problem, effects_alone);
    changed = !push && left_out(&Hypotheses::has_event, with, again.search);
    const bool pattern =
        leads(&Hypotheses::has_pattern) && pattern_established(with, again.search, tried);
    changed = (!pattern && left_out(&Hypotheses::has_pattern, with, again.search)) || changed;
  }
}

}  // namespace

Searched search_with_forces(Prepared prepared, const ProblemBuilder& rebuild,
                            const DiagnoseOptions& options) {
  if (!prepared.reasons.empty()) return {std::move(prepared), {}, {}};
  Selection effects_alone = selected(prepared, rebuild, options);
  if (!forces_sought(prepared, effects_alone))
    return {std::move(prepared), std::move(effects_alone), {}};

  if (options.progress) options.progress("pushes and forces of other forms");
  const std::vector<effects::Effect> pushes = likely_push_effects(prepared, effects_alone, options);
  CandidatePatterns likely = candidate_patterns(prepared, effects_alone);
  if (pushes.empty() && likely.patterns.empty())
    return {std::move(prepared), std::move(effects_alone), {}};
  std::vector<effects::Effect> effects =
      fitted_effects(*prepared.built.problem, effects_alone.search);
  effects.insert(effects.end(), pushes.begin(), pushes.end());
  for (const PlacePattern& pattern : likely.patterns) effects.push_back(pattern_effect(pattern));
  Prepared with = with_effects(prepared, std::move(effects));
  Selection again = selected(with, rebuild, options);

  const Problem& problem = *with.built.problem;
  if (again.search.models.empty()) return {std::move(prepared), std::move(effects_alone), {}};
  leave_out_unfounded(problem, *prepared.built.problem, effects_alone.search, likely.tried, again);
  if (!goes_beyond_effects(problem, leading(again.search)))
    return {std::move(prepared), std::move(effects_alone), {}};
  return {std::move(with), std::move(again), std::move(likely.patterns)};
}

}  // namespace jaculus::diagnosis
