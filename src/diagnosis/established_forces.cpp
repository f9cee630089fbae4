#include "diagnosis/established_forces.h"

#include <algorithm>
#include <cmath>

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

/// By how much the most probable model leads none [log weight].
double lead_over_none(const SearchResult& search) {
  return leading(search).log_weight() - search.models.front().log_weight();
}

/// The most probable of those that may stand in its place, none where all are out.
template <typename MayStand>
const ModelFit* rival(const SearchResult& search, const MayStand& may_stand) {
  const ModelFit* best = nullptr;
  for (const ModelFit& model : search.models)
    if (may_stand(model) && (best == nullptr || model.log_weight() > best->log_weight()))
      best = &model;
  return best;
}

/// By how much the most probable model leads another [log weight].
double lead_over(const ModelFit* other, const SearchResult& search) {
  return other == nullptr ? kInfinity : leading(search).log_weight() - other->log_weight();
}

double lead_over_effects(const Problem& problem, const SearchResult& search) {
  const auto of_effects = [&](const ModelFit& model) {
    return !problem.hypotheses.beyond_effects(model.candidates);
  };
  return lead_over(rival(search, of_effects), search);
}

/// Effects of the leading model, pushes and patterns left out.
int effects_of_leading(const Problem& problem, const SearchResult& search) {
  const std::vector<int>& members = leading(search).candidates;
  return static_cast<int>(std::count_if(members.begin(), members.end(), [&](int c) {
    return !problem.hypotheses.candidates[c].beyond_effects();
  }));
}

/// Whether a push takes the place of effects, and clearly leads the best model of effects alone.
bool is_simpler(const Problem& with, const SearchResult& with_pushes,
                const SearchResult& effects_alone) {
  return effects_of_leading(with, with_pushes) < count_of(leading(effects_alone).candidates) &&
         lead_over_effects(with, with_pushes) > with.settings.clear_lead;
}

/// Whether the leading model's push is established, and takes the place of an effect where effects
/// alone left nothing more.
bool push_holds(const Problem& with, const Selection& again, const EffectsAlone& alone) {
  return push_established(with, again.search, alone.search) &&
         (leaves_more(alone.problem, leading(alone.search).fit) ||
          is_simpler(with, again.search, alone.search));
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

/// The first member of the leading model that is no effect and doesn't hold; -1 where all do.
int unfounded_member(const Problem& with, const EffectsAlone& alone, int tried,
                     const Selection& again) {
  for (const int c : leading(again.search).candidates) {
    const Candidate& own = with.hypotheses.candidates[c];
    if (own.is_event() && !push_holds(with, again, alone)) return c;
    if (own.is_pattern() && !pattern_established(with, again.search, c, tried)) return c;
  }
  return -1;
}

}  // namespace

const ModelFit& leading(const SearchResult& search) {
  return *std::max_element(
      search.models.begin(), search.models.end(),
      [](const ModelFit& a, const ModelFit& b) { return a.log_weight() < b.log_weight(); });
}

bool push_established(const Problem& problem, const SearchResult& with_pushes,
                      const SearchResult& effects_alone) {
  const Settings& settings = problem.settings;
  if (!lacks(problem, leading(with_pushes).fit)) return true;
  return lead_over_none(effects_alone) < settings.bare_mention &&
         lead_over_effects(problem, with_pushes) > settings.clear_lead;
}

bool pattern_established(const Problem& problem, const SearchResult& search, int pattern,
                         int tried) {
  const std::vector<int> present = leading(search).candidates;
  const ModelFit* without = rival(search, [&](const ModelFit& model) {
    return std::all_of(model.candidates.begin(), model.candidates.end(), [&](int c) {
      const bool stays = c != pattern && std::binary_search(present.begin(), present.end(), c);
      return stays || !problem.hypotheses.candidates[c].is_pattern();
    });
  });
  const Settings& settings = problem.settings;
  const bool more = without != nullptr && leaves_more(problem, without->fit);
  const double least = more ? settings.worth : settings.clear_lead;
  return lead_over(without, search) > least + std::log(std::max(1, tried));
}

void leave_out_unfounded(const Problem& with, const EffectsAlone& alone, int tried,
                         Selection& again) {
  // A push that is none in itself is no rival of a pattern either.
  std::erase_if(again.search.models, [&](const ModelFit& model) {
    return with.hypotheses.has_event(model.candidates) &&
           !has_one_push(with, again.comparison.whitening, model);
  });
  for (int c = unfounded_member(with, alone, tried, again); c >= 0;
       c = unfounded_member(with, alone, tried, again))
    leave_out(c, again.search);

  const std::vector<int> members = leading(again.search).candidates;
  for (int c = 0; c < count_of(with.hypotheses.candidates); ++c)
    if (with.hypotheses.candidates[c].beyond_effects() &&
        !std::binary_search(members.begin(), members.end(), c))
      leave_out(c, again.search);
}

}  // namespace jaculus::diagnosis
