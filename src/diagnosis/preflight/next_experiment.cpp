#include "diagnosis/preflight/next_experiment.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/build_problem.h"
#include "diagnosis/preflight/experiments.h"
#include "jaculus/core/error.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {
namespace {

using effects::Effect;
using model::PlanarModel;
using simulation::Controller;
using simulation::Experiment;
using simulation::Plant;
using simulation::SimulationStatus;
using simulation::TrialRun;
using trajectory::Dataset;

/// Trials of an experiment on the plant with a rival's effects; nothing where the plant is lost.
std::optional<Dataset> simulated(const Experiment& experiment, const Rival& rival) {
  const PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  Plant plant = simulation::dataset_plant(experiment.setup, model);
  for (std::size_t i = 0; i < rival.effects.size(); ++i)
    if (rival.effects[i]->applies(model)) rival.effects[i]->apply(rival.theta[i], plant);
  const Controller controller = experiment_controller(experiment, model);
  Dataset dataset = experiment.setup;
  for (int k = 0; k < experiment.trials; ++k) {
    const TrialRun run = run_trial(experiment, plant, controller, k, 1);
    if (run.truth.status != SimulationStatus::done) return std::nullopt;
    dataset.trials.push_back(run.trial);
  }
  return dataset;
}

/// A rival's effects as candidates of a problem, its parameters set; effects that don't act there
/// stay away.
FittedModel start_at(const Problem& problem, const Rival& rival) {
  FittedModel model{{}, problem.hypotheses.nominal()};
  for (std::size_t i = 0; i < rival.effects.size(); ++i) {
    const int c = problem.hypotheses.candidate(rival.effects[i]->name);
    if (c < 0) continue;
    model.candidates.push_back(c);
    const auto& own = problem.hypotheses.candidates[c].parameters;
    for (std::size_t k = 0; k < own.size(); ++k) model.p[own[k]] = rival.theta[i][k];
  }
  return model;
}

/// Mean over both rivals of the evidence for the one that made the data; NaN where one can't be
/// simulated or fitted.
double expected_log_bayes_factor(const Experiment& experiment, const Rival& a, const Rival& b,
                                 const DiagnoseOptions& options) {
  double sum = 0.0;
  for (const bool first : {true, false}) {
    const Rival& truth = first ? a : b;
    const std::optional<Dataset> data = simulated(experiment, truth);
    if (!data) return kNaN;
    const std::vector<double> evidence = log_evidences({*data}, {truth, first ? b : a}, options);
    sum += evidence[0] - evidence[1];
  }
  return 0.5 * sum;
}

}  // namespace

std::vector<double> log_evidences(const std::vector<Dataset>& datasets,
                                  const std::vector<Rival>& rivals,
                                  const DiagnoseOptions& options) {
  DiagnoseOptions all = options;
  all.effects.clear();
  for (const Rival& rival : rivals)
    for (const Effect* effect : rival.effects)
      if (std::find(all.effects.begin(), all.effects.end(), effect) == all.effects.end())
        all.effects.push_back(effect);

  std::vector<double> found(rivals.size(), kNaN);
  BuiltProblem built = build_problem(datasets, all);
  if (!built.forward) return found;
  const Prepared prepared = prepare(std::move(built), builder_of(all));
  if (!prepared.reasons.empty()) return found;
  const Problem& problem = *prepared.built.problem;
  Comparison comparison = first_comparison(problem, prepared.noise);
  const Vector p = comparison.noise.p;
  const FittedModel first = start_at(problem, rivals.front());
  NoiseModel there = estimate_noise(problem, first.p, comparison.noise.alignments);
  if (there.valid())
    comparison = comparison_about(problem, with_random_effects(problem, std::move(there)));

  // The robot that is simulated has the files' values: slopes there say what tolerances do.
  LinearNuisances linear = linear_nuisances(problem, comparison.whitening, comparison.noise.p);
  linear.p = p;  // the same tolerances, without the first rival
  FitOptions by_slopes;
  by_slopes.by_slopes = &linear;
  for (std::size_t r = 0; r < rivals.size(); ++r) {
    const FittedModel start = start_at(problem, rivals[r]);
    const std::vector<int> free = problem.hypotheses.freed_by(start.candidates);
    const Fit anew = fit_members_by_slopes(problem, comparison.whitening, linear, start.candidates);
    const Fit from = fit_model(problem, comparison.whitening, free, {start.p}, by_slopes);
    for (const Fit* fit : {&anew, &from})
      if (fit->valid && !(fit->log_evidence < found[r])) found[r] = fit->log_evidence;
  }
  return found;
}

std::optional<NextExperiment> next_experiment(const Dataset& present, const Problem& problem,
                                              const NoiseModel& noise, const Rival& a,
                                              const Rival& b, const DiagnoseOptions& options) {
  std::optional<NextExperiment> best;
  for (const ExperimentMaker& make : possible_experiments(present, problem, noise)) {
    try {
      const NamedExperiment named = make();
      const double expected = expected_log_bayes_factor(named.experiment, a, b, options);
      const bool telling = expected >= problem.settings.telling;
      if (telling && (!best || expected > best->log_bayes_factor)) best = {{named.name, expected}};
    } catch (const InputError&) {
      continue;  // the robot or its stated controller does not allow this experiment
    }
  }
  return best;
}

}  // namespace jaculus::diagnosis
