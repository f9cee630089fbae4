#include "diagnosis/preflight/next_experiment.h"

#include <algorithm>

#include "diagnosis/preflight/expected_evidence.h"
#include "diagnosis/preflight/experiments.h"
#include "jaculus/core/error.h"

namespace jaculus::diagnosis {
namespace {

using simulation::Experiment;

/// Of a rival's departure, at which it and what imitates it are simulated.
const std::vector<double> kRivalShares = {0.25, 0.5, 1.0, 2.0};

/// Options with both rivals' effects and no others.
DiagnoseOptions between(const Explanation& a, const Explanation& b, DiagnoseOptions options) {
  options.effects.clear();
  for (const Explanation* rival : {&a, &b})
    for (const effects::Effect* effect : rival->effects)
      if (std::find(options.effects.begin(), options.effects.end(), effect) ==
          options.effects.end())
        options.effects.push_back(effect);
  return options;
}

/// Along a rival's departure; effects that don't act in this experiment stay away.
SignatureCurve curve_of(const SignatureSpace& space, const Explanation& rival) {
  const Hypotheses& hypotheses = space.problem->hypotheses;
  std::vector<int> candidates;
  Vector p = hypotheses.nominal();
  for (std::size_t i = 0; i < rival.effects.size(); ++i) {
    const int c = hypotheses.candidate(rival.effects[i]->name);
    if (c < 0) continue;
    candidates.push_back(c);
    const std::vector<int>& own = hypotheses.candidates[c].parameters;
    for (std::size_t k = 0; k < own.size(); ++k) p[own[k]] = rival.theta[i][k];
  }
  return signature_curve(space, candidates, p, kRivalShares);
}

/// Mean over both rivals; NaN where one can't be simulated.
double told_between(const Experiment& experiment, const Explanation& a, const Explanation& b,
                    const DiagnoseOptions& options) {
  const PlannedSpace planned =
      space_of({experiment}, between(a, b, options), MissingForces::left_out);
  if (!planned.space) return kNaN;
  const SignatureSpace& space = *planned.space;
  const SignatureCurve of_a = curve_of(space, a), of_b = curve_of(space, b);
  return 0.5 * (expected_log_bayes_factor(space, of_a, of_b) +
                expected_log_bayes_factor(space, of_b, of_a));
}

}  // namespace

std::optional<NextExperiment> next_experiment(const trajectory::Dataset& present,
                                              const Problem& problem, const NoiseModel& noise,
                                              const Explanation& a, const Explanation& b,
                                              const DiagnoseOptions& options) {
  if (present.controller.kind == trajectory::ControllerKind::measured ||
      (!present.plan && !present.script))
    return {};

  std::optional<NextExperiment> best;
  const Experiment now = present_experiment(present, problem, noise);
  for (const ExperimentMaker& make : possible_experiments(now, problem.settings)) {
    try {
      const NamedExperiment named = make();
      const double expected = told_between(named.experiment, a, b, options);
      const bool telling = expected >= problem.settings.telling;
      if (telling && (!best || expected > best->log_bayes_factor)) best = {{named.name, expected}};
    } catch (const InputError&) {
      continue;  // the robot or its stated controller does not allow this experiment
    }
  }
  return best;
}

}  // namespace jaculus::diagnosis
