#include "diagnosis/established_forces.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "diagnosis/validation/held_out.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kOfIt = 0.5;     ///< share of a push that every trial has at least
constexpr double kSure = 3.0;     ///< deviations
constexpr double kInside = 1.01;  ///< a length so near its bound is at it

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
  if (!model.fit.valid || model.fit.jacobian.cols() == 0) return false;
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

/// How many forces were tried of which a candidate is one: patterns, or pushes along so many
/// coordinates. When a push acts and for how long are parameters, for which its evidence pays.
int tried_like(const Problem& with, const Candidate& candidate, int patterns) {
  return candidate.is_event() ? count_of(with.hypotheses.forces) : patterns;
}

/// How many effects of the catalogue some candidates are.
int effects_among(const Problem& problem, const std::vector<int>& candidates) {
  return static_cast<int>(std::count_if(candidates.begin(), candidates.end(), [&](int c) {
    return !problem.hypotheses.candidates[c].beyond_effects();
  }));
}

/// A model's evidence with the prior of so many effects; a force was not one of the catalogue's, so
/// that it costs how many like it were tried, and not what one effect more does besides.
double charged_weight(const Problem& problem, const ModelFit& model, int effects,
                      int patterns_tried) {
  const std::vector<Candidate>& all = problem.hypotheses.candidates;
  const auto catalogue = std::count_if(all.begin(), all.end(),
                                       [](const Candidate& own) { return !own.beyond_effects(); });
  double weight = model.log_weight() - model.log_prior +
                  log_prior(static_cast<std::size_t>(effects), static_cast<std::size_t>(catalogue),
                            problem.settings);
  for (const int c : model.candidates)
    if (all[c].beyond_effects())
      weight -= std::log(std::max(1, tried_like(problem, all[c], patterns_tried)));
  return weight;
}

/// The most probable model by that weight without a candidate, and without any push or pattern that
/// the leading model doesn't have. That without effects is one of them.
const ModelFit& best_without(const Problem& problem, const SearchResult& search, int candidate,
                             int patterns_tried) {
  const std::vector<int>& present = leading(search).candidates;
  const auto may_have = [&](int c) {
    const bool stays = c != candidate && std::binary_search(present.begin(), present.end(), c);
    return stays || !problem.hypotheses.candidates[c].beyond_effects();
  };
  const ModelFit* best = nullptr;
  double most = -kInfinity;
  for (const ModelFit& model : search.models) {
    if (!std::all_of(model.candidates.begin(), model.candidates.end(), may_have)) continue;
    const int effects = effects_among(problem, model.candidates);
    const double weight = charged_weight(problem, model, effects, patterns_tried);
    if (best != nullptr && weight <= most) continue;
    best = &model;
    most = weight;
  }
  assert(best != nullptr);
  return *best;
}

/// A candidate as if it had not been one.
void leave_out(int candidate, SearchResult& search) {
  std::erase_if(search.models, [&](const ModelFit& model) {
    return std::binary_search(model.candidates.begin(), model.candidates.end(), candidate);
  });
  search.probes[candidate].valid = false;
  search.probes[candidate].score = -kInfinity;
  for (std::vector<int>& alike : search.indistinguishable) std::erase(alike, candidate);
}

/// Whether every force of the leading model that is no effect holds.
bool all_hold(const Problem& with, int patterns_tried, const SearchResult& search) {
  const std::vector<int>& members = leading(search).candidates;
  return std::all_of(members.begin(), members.end(), [&](int c) {
    const Candidate& own = with.hypotheses.candidates[c];
    return !own.beyond_effects() || force_established(with, search, c, patterns_tried);
  });
}

/// What a selection's leading model leaves of trials that its fit did not see.
HeldOut held_out_of_leader(const Led& led) {
  const auto& [problem, selection] = led;
  const Posterior posterior = posterior_of(selection.search, problem.settings);
  HeldOutGaps gaps(problem, selection.comparison, posterior,
                   as_stated(problem, selection.comparison.whitening),
                   selection.search.models.front().fit);
  return gaps.of(leading(selection.search));
}

}  // namespace

const ModelFit& leading(const SearchResult& search) {
  return *most_probable(search.models, [](const ModelFit&) { return true; });
}

bool force_established(const Problem& problem, const SearchResult& search, int candidate,
                       int patterns_tried) {
  const Settings& settings = problem.settings;
  const ModelFit &lead = leading(search),
                 &without = best_without(problem, search, candidate, patterns_tried);
  const double least = leaves_more(problem, without.fit) ? settings.worth : settings.clear_lead;
  // A force in the place of an effect is charged as that: it shall not lead by its prior.
  const int beside = effects_among(problem, without.candidates);
  const int effects = std::max(beside, effects_among(problem, lead.candidates));
  return charged_weight(problem, lead, effects, patterns_tried) -
             charged_weight(problem, without, beside, patterns_tried) >
         least;
}

void leave_out_unfounded(const Problem& with, int patterns_tried, Selection& again) {
  // A push that is none in itself is no rival of a pattern either.
  std::erase_if(again.search.models, [&](const ModelFit& model) {
    return with.hypotheses.has_event(model.candidates) &&
           !has_one_push(with, again.comparison.whitening, model);
  });
  while (!all_hold(with, patterns_tried, again.search)) {
    const std::vector<int> lead = leading(again.search).candidates;
    std::erase_if(again.search.models,
                  [&](const ModelFit& model) { return model.candidates == lead; });
  }

  const std::vector<int> members = leading(again.search).candidates;
  for (int c = 0; c < count_of(with.hypotheses.candidates); ++c)
    if (with.hypotheses.candidates[c].beyond_effects() &&
        !std::binary_search(members.begin(), members.end(), c))
      leave_out(c, again.search);
}

bool predicts_as_well(const Led& by_force, const Led& by_effects) {
  const HeldOut with = held_out_of_leader(by_force), without = held_out_of_leader(by_effects);
  if (!without.valid) return true;
  if (!with.valid || with.folds < without.folds) return false;
  return no_worse(with.after / with.before, without.after / without.before,
                  by_effects.problem.settings);
}

}  // namespace jaculus::diagnosis
