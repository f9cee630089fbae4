#include "jaculus/diagnosis/diagnose.h"

#include <numeric>

#include "diagnosis/build_problem.h"
#include "diagnosis/localise/localise.h"
#include "diagnosis/preflight/next_experiment.h"
#include "diagnosis/verdict/statement.h"

namespace jaculus::diagnosis {
namespace {

void tell(const DiagnoseOptions& options, const std::string& what) {
  if (options.progress) options.progress(what);
}

/// Whether one trial alone would have to tell its own noise.
bool one_trial(const Observations& observations, const Settings& settings) {
  int trials = 0;
  bool windows = false;
  for (const ObservedDataset& observed : observations.datasets) {
    trials += observed.trials;
    windows = windows || observed.measured_input;
  }
  return trials < settings.fewest_trials && !windows;
}

/// What the data alone say: why they can't answer, what was left out.
Diagnosis unanswered(const Prepared& prepared) {
  Diagnosis out;
  const Observations& observations = prepared.built.problem->observations;
  out.reasons = prepared.reasons;
  out.notes = observations.notes;
  out.notes.insert(out.notes.end(), prepared.notes.begin(), prepared.notes.end());
  out.disturbances = prepared.disturbances;
  out.settings = prepared.built.problem->settings;
  if (!observations.datasets.empty()) out.problem = prepared.built.problem;
  return out;
}

Diagnosis answered(const Prepared& prepared, const Selection& selection,
                   const Statement& statement) {
  Diagnosis out = unanswered(prepared);
  out.verdict = statement.verdict;
  out.rule = statement.rule;
  out.reasons = statement.reasons;
  out.effects = statement.effects;
  out.ranking = statement.ranking;
  out.gap = statement.gap;
  out.lacking_probability = statement.lacking_probability;
  out.lacking = statement.lacking;
  out.rivals = statement.rivals;
  out.none = statement.none;
  out.model = statement.model;
  out.predictions = selection.search.predictions;
  out.noise = std::make_shared<const NoiseModel>(selection.comparison.noise);
  return out;
}

/// The two leading rivals, for what to do next about them.
Rival rival_of(const Problem& problem, const FittedModel& model) {
  Rival rival;
  for (const int c : model.candidates) {
    const Candidate& candidate = problem.hypotheses.candidates[c];
    rival.effects.push_back(candidate.effect);
    rival.theta.push_back(candidate.theta(model.p));
  }
  return rival;
}

/// The whole pipeline. `present`: what to suggest experiments about; null for models that are no
/// plant.
Diagnosis run_pipeline(BuiltProblem built, const ProblemBuilder& rebuild,
                       const trajectory::Dataset* present, const DiagnoseOptions& options) {
  tell(options, "noise and alignment");
  const Prepared prepared = prepare(std::move(built), rebuild);
  if (!prepared.reasons.empty()) return unanswered(prepared);

  const Problem& problem = *prepared.built.problem;
  const Selection selection =
      select_models(problem, first_comparison(problem, prepared.noise), options.progress);
  if (selection.search.models.empty()) {
    Diagnosis out = unanswered(prepared);
    out.reasons.emplace_back("the nominal model can't be fitted to these data");
    return out;
  }

  tell(options, "held-out gap and intervals");
  const Statement statement =
      state_verdict(problem, selection, one_trial(problem.observations, problem.settings));
  Diagnosis out = answered(prepared, selection, statement);
  if (!prepared.built.forward || present == nullptr) return out;

  tell(options, "where the gap lies");
  out.where =
      localise(problem, *prepared.built.forward, selection, statement.posterior, statement.verdict);
  if (out.rivals.size() == 2) {
    tell(options, "what to do next");
    out.next = next_experiment(*present, problem, *out.noise, rival_of(problem, out.rivals[0]),
                               rival_of(problem, out.rivals[1]), options);
    if (!out.next && !problem.observations.datasets.front().measured_input)
      out.reasons.emplace_back(
          "no experiment that could be simulated is expected to tell the two leading rivals apart");
  }
  return out;
}

/// What observation alone found insufficient.
Diagnosis insufficient(const Problem& problem) {
  Diagnosis out;
  out.reasons = problem.observations.insufficient;
  out.notes = problem.observations.notes;
  out.settings = problem.settings;
  return out;
}

}  // namespace

Diagnosis diagnose(const std::vector<trajectory::Dataset>& datasets,
                   const DiagnoseOptions& options) {
  BuiltProblem built = build_problem(datasets, options);
  if (!built.forward) return insufficient(*built.problem);
  return run_pipeline(std::move(built), builder_of(options), &datasets.front(), options);
}

Diagnosis diagnose_problem(const Problem& problem, const DiagnoseOptions& options) {
  if (problem.observations.datasets.empty() || !problem.observations.insufficient.empty())
    return insufficient(problem);
  return run_pipeline({std::make_shared<const Problem>(problem), {}}, builder_like(problem),
                      nullptr, options);
}

HeldOut held_out_with(const std::vector<trajectory::Dataset>& datasets,
                      const DiagnoseOptions& options) {
  BuiltProblem built = build_problem(datasets, options);
  if (!built.forward) return {};
  const Prepared prepared = prepare(std::move(built), builder_of(options));
  if (!prepared.reasons.empty()) return {};

  const Problem& problem = *prepared.built.problem;
  Comparison comparison = first_comparison(problem, prepared.noise);
  std::vector<int> members(problem.hypotheses.candidates.size());
  std::iota(members.begin(), members.end(), 0);
  const Fit model = fit_members(problem, comparison.whitening, comparison.noise.p, members);
  if (!model.valid) return {};

  const Relinearised about = relinearise(problem, std::move(comparison), model);
  const Fit none = fit_model(problem, about.comparison.whitening, problem.hypotheses.nuisances,
                             {problem.hypotheses.nominal()});
  return none.valid ? held_out(problem, about.comparison, none, about.fit) : HeldOut{};
}

}  // namespace jaculus::diagnosis
