#include "jaculus/diagnosis/preflight.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/preflight/detection.h"
#include "diagnosis/preflight/isolability.h"
#include "diagnosis/preflight/sensors_added.h"
#include "jaculus/core/error.h"
#include "jaculus/effects/select.h"

namespace jaculus::diagnosis {
namespace {

using simulation::Experiment;

/// Shares of the stated departure at which signatures of the planned experiment are simulated, both
/// ways, as far as screening's line search goes; and, for changes of it, coarser ones.
const std::vector<double> kFineShares = {0.125, -0.125, 0.5, -0.5, 1.0, -1.0, 2.0, -2.0, 8.0, -8.0};
const std::vector<double> kCoarseShares = {0.25, -0.25, 1.0, -1.0};

std::vector<SignatureCurve> curves_of(const SignatureSpace& space, double size,
                                      const std::vector<double>& shares) {
  std::vector<SignatureCurve> curves(space.problem->hypotheses.candidates.size());
  tbb::parallel_for(0, count_of(curves), [&](int c) {
    curves[c] = signature_curve(space, {c}, stated_departure(*space.problem, c, size), shares);
  });
  return curves;
}

PlannedEffect planned_effect(const Problem& problem, int c, const Vector& departure,
                             const Detection& found) {
  const Candidate& candidate = problem.hypotheses.candidates[c];
  const effects::EffectParameter& own = candidate.effect->parameters.front();
  const auto shown = [&](double departed) {
    return effects::shown_value(own, own.nominal + departed);
  };
  PlannedEffect out{candidate.name, candidate.effect->caption, own.shown_name(), own.shown_unit()};
  out.structural = found.structural;
  out.stated = shown(departure[candidate.parameters.front()] - own.nominal);
  out.log_odds = found.stated.log_odds;
  out.gap = found.stated.gap;
  out.named = found.stated.named;
  if (std::isnan(found.size)) return out;

  out.least = shown(found.size);
  out.least_scales = std::abs(found.size) / own.scale;
  const double bound = found.size > 0.0 ? own.bounds.upper : own.bounds.lower;
  if (std::isfinite(bound)) out.least_of_bounds = found.size / (bound - own.nominal);
  return out;
}

/// The planned experiment as all that follows sees it.
struct Plan {
  const Experiment& experiment;
  const PreflightOptions& options;
  SignatureSpace space;
  std::vector<SignatureCurve> curves;  ///< a candidate each
  std::vector<bool> seen;              ///< a candidate each: named as stated
  std::vector<double> chance;          ///< a candidate each: share of the data that name it
  std::vector<CandidatePair> pairs;

  [[nodiscard]] const Hypotheses& hypotheses() const { return space.problem->hypotheses; }
  [[nodiscard]] const Settings& settings() const { return space.problem->settings; }
  /// The same candidates, as this robot has them; of some of them.
  [[nodiscard]] DiagnoseOptions with_candidates(const std::vector<int>& which) const {
    DiagnoseOptions same = options.diagnosis;
    same.effects.clear();
    for (const int c : which) same.effects.push_back(hypotheses().candidates[c].effect);
    return same;
  }
  [[nodiscard]] DiagnoseOptions with_all_candidates() const {
    std::vector<int> all;
    for (int c = 0; c < count_of(curves); ++c) all.push_back(c);
    return with_candidates(all);
  }
};

std::vector<CandidatePair> not_told(const Plan& plan) {
  std::vector<CandidatePair> out;
  for (const CandidatePair& pair : plan.pairs)
    if (pair.not_tellable(plan.settings())) out.push_back(pair);
  return out;
}

/// Another space with the same candidates or some of them.
struct Changed {
  PlannedSpace planned;
  std::vector<SignatureCurve> curves;
  Matrix factors;  ///< expected log Bayes factors
};

/// Nothing where the plant is lost or data could not be diagnosed.
std::optional<Changed> changed(const std::vector<Experiment>& experiments,
                               const DiagnoseOptions& options, double size) {
  Changed out{space_of(experiments, options, MissingForces::left_out), {}, {}};
  if (!out.planned.space) return {};
  out.curves = curves_of(*out.planned.space, size, kCoarseShares);
  out.factors = expected_log_bayes_factors(*out.planned.space, out.curves);
  return out;
}

/// What a pair's lesser way is told by there; NaN where a curve is missing.
double told_there(const Changed& there, const Hypotheses& planned, const CandidatePair& pair) {
  const Hypotheses& own = there.planned.space->problem->hypotheses;
  const int a = own.candidate(planned.candidates[pair.a].name);
  const int b = own.candidate(planned.candidates[pair.b].name);
  if (a < 0 || b < 0) return kNaN;
  if (std::isnan(pair.told_a)) return there.factors(b, a);
  if (std::isnan(pair.told_b)) return there.factors(a, b);
  return std::min(there.factors(a, b), there.factors(b, a));
}

/// Adds a change to the pairs that it tells; how many these are.
int add_told(const Plan& plan, const Changed& there, const std::string& kind,
             const std::string& name, Preflight& out) {
  int told = 0;
  for (std::size_t i = 0; i < plan.pairs.size(); ++i) {
    if (out.pairs[i].tellable) continue;
    const double factor = told_there(there, plan.hypotheses(), plan.pairs[i]);
    if (!(factor >= plan.settings().indistinguishable_below)) continue;
    out.pairs[i].by.push_back({kind, name, factor});
    ++told;
  }
  return told;
}

void try_sensors(const Plan& plan, Preflight& out) {
  std::vector<int> members;
  for (const CandidatePair& pair : not_told(plan))
    for (const int c : {pair.a, pair.b})
      if (index_of(members, c) < 0) members.push_back(c);
  if (members.empty()) return;
  std::sort(members.begin(), members.end());

  const DiagnoseOptions options = plan.with_candidates(members);
  const model::PlanarModel model = simulation::dataset_robot(plan.experiment.setup).planar;
  for (const NamedExperiment& sensor :
       with_one_more_sensor(plan.experiment, model, plan.settings())) {
    if (options.progress) options.progress("sensor: " + sensor.name);
    const auto there = changed({sensor.experiment}, options, out.size);
    if (there) add_told(plan, *there, "sensor", sensor.name, out);
  }
}

void try_motions(const Plan& plan, Preflight& out) {
  const DiagnoseOptions options = plan.with_all_candidates();
  for (const ExperimentMaker& make : possible_experiments(plan.experiment, plan.settings())) {
    try {
      const NamedExperiment motion = make();
      if (options.progress) options.progress("motion: " + motion.name);
      const auto there = changed({plan.experiment, motion.experiment}, options, out.size);
      if (!there) continue;
      const int told = add_told(plan, *there, "motion", motion.name, out);
      // Both together tell no less than the planned one; the bound of each may be looser.
      const double both = information_of(there->factors, there->curves, plan.settings());
      out.following.push_back({motion.name, std::max(out.information, both), told});
    } catch (const InputError&) {
      continue;  // the robot or its stated controller does not allow this experiment
    }
  }
  std::stable_sort(out.following.begin(), out.following.end(),
                   [](const auto& a, const auto& b) { return a.information > b.information; });
}

PlannedPair planned_pair(const CandidatePair& pair, const Plan& plan) {
  const Settings& settings = plan.settings();
  const Hypotheses& hypotheses = plan.hypotheses();
  const TellingWay a{pair.told_a, pair.spread_a, plan.chance[pair.a],
                     rival_of(hypotheses, pair.a, pair.b)};
  const TellingWay b{pair.told_b, pair.spread_b, plan.chance[pair.b],
                     rival_of(hypotheses, pair.b, pair.a)};
  PlannedPair out{hypotheses.candidates[pair.a].name, hypotheses.candidates[pair.b].name,
                  pair.told_a, pair.told_b};
  out.with_a = telling_of(a, settings);
  out.with_b = telling_of(b, settings);
  if (out.with_a != Telling::not_judged) out.chance_a = telling_chances(a, settings).told;
  if (out.with_b != Telling::not_judged) out.chance_b = telling_chances(b, settings).told;
  out.structural = pair.structural(settings);
  const auto told = [](Telling way) { return way == Telling::told || way == Telling::not_judged; };
  out.tellable = told(out.with_a) && told(out.with_b);
  return out;
}

void add_pairs(const Plan& plan, Preflight& out) {
  const std::vector<Candidate>& candidates = plan.hypotheses().candidates;
  for (const CandidatePair& pair : plan.pairs) out.pairs.push_back(planned_pair(pair, plan));
  for (const std::vector<int>& set : connected_sets(not_told(plan), count_of(candidates))) {
    out.sets.emplace_back();
    for (const int c : set) out.sets.back().push_back(candidates[c].name);
  }
}

}  // namespace

Preflight preflight(const Experiment& experiment, const PreflightOptions& options) {
  Preflight out;
  out.experiment = experiment.name;
  out.robot = experiment.setup.robot;
  out.size = options.size;
  out.settings = options.diagnosis.settings;
  const auto tell = [&](const std::string& what) {
    if (options.diagnosis.progress) options.diagnosis.progress(what);
  };

  tell("simulating the experiment");
  PlannedSpace planned = space_of({experiment}, options.diagnosis, MissingForces::granted);
  out.reasons = planned.reasons;
  out.notes = planned.notes;
  if (experiment.trials < out.settings.fewest_trials)
    out.reasons.push_back("one trial: a diagnosis could only guess its noise; plan three or more");
  if (!planned.space || !out.reasons.empty()) return out;

  tell("signatures of effects");
  Plan plan{experiment, options, std::move(*planned.space), {}, {}, {}, {}};
  plan.curves = curves_of(plan.space, out.size, kFineShares);
  tell("least sizes");
  const int n = count_of(plan.curves);
  std::vector<Detection> found(n);
  tbb::parallel_for(0, n, [&](int c) {
    const Vector departure = stated_departure(*plan.space.problem, c, out.size);
    found[c] = detect(plan.space, c, plan.curves[c], departure);
  });
  for (int c = 0; c < n; ++c) {
    const Vector departure = stated_departure(*plan.space.problem, c, out.size);
    out.effects.push_back(planned_effect(*plan.space.problem, c, departure, found[c]));
    plan.seen.push_back(found[c].stated.named);
    plan.chance.push_back(found[c].stated.chance);
  }

  tell("pairs of effects");
  Matrix spread;
  const Matrix factors = expected_log_bayes_factors(plan.space, plan.curves, &spread);
  plan.pairs = candidate_pairs(plan.curves, factors, plan.seen, spread);
  add_pairs(plan, out);
  // By the coarser sizes that what may follow is judged by, or more data could seem to tell less.
  const auto alone = changed({experiment}, plan.with_all_candidates(), out.size);
  out.information = alone ? information_of(alone->factors, alone->curves, out.settings)
                          : information_of(factors, plan.curves, out.settings);
  out.uncertainty = prior_uncertainty(n, out.settings);
  if (!options.alternatives) return out;

  try_sensors(plan, out);
  try_motions(plan, out);
  for (PlannedPair& pair : out.pairs)
    std::stable_sort(pair.by.begin(), pair.by.end(), [](const auto& a, const auto& b) {
      return a.log_bayes_factor > b.log_bayes_factor;
    });
  return out;
}

}  // namespace jaculus::diagnosis
