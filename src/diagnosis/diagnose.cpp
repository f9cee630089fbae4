#include "jaculus/diagnosis/diagnose.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "diagnosis/build_problem.h"
#include "diagnosis/describe_remainder.h"
#include "diagnosis/localise/localise.h"
#include "diagnosis/localise/postures.h"
#include "diagnosis/motion_patterns.h"
#include "diagnosis/preflight/next_experiment.h"
#include "diagnosis/read_tolerances.h"
#include "diagnosis/search_with_forces.h"
#include "diagnosis/validation/agreement.h"
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
  out.partings = observations.partings;
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
  for (const ToldPush& push : statement.pushes) out.events.push_back(push.event);
  out.ranking = statement.ranking;
  out.gap = statement.gap;
  out.lacking_probability = statement.lacking_probability;
  out.lacking = statement.lacking;
  out.rivals = statement.rivals;
  out.stated = statement.stated;
  out.none = statement.none;
  out.model = statement.model;
  out.theta = statement.theta;
  out.tolerated = statement.tolerated;
  out.predictions = selection.search.predictions;
  out.noise = std::make_shared<const NoiseModel>(selection.comparison.noise);
  return out;
}

/// A note on each effect of a user's file that is not named: what one wrote down is not to vanish.
std::vector<std::string> notes_of_own(const Problem& problem, const SearchResult& search,
                                      const std::vector<FoundEffect>& named) {
  std::vector<std::string> notes;
  for (int c = 0; c < count_of(problem.hypotheses.candidates); ++c) {
    const Candidate& own = problem.hypotheses.candidates[c];
    const auto is_own = [&](const FoundEffect& found) { return found.name == own.name; };
    if (own.effect == nullptr || own.effect->file.empty() || own.is_pattern() ||
        own.effect->event || std::any_of(named.begin(), named.end(), is_own))
      continue;
    const std::string file = std::filesystem::path(own.effect->file).filename().string();
    double gain = search.probes[c].valid ? search.probes[c].score : kNaN;
    for (const ModelFit& model : search.models)
      if (model.candidates == std::vector<int>{c} && model.fit.valid)
        gain = model.log_evidence() - search.models.front().log_evidence();
    notes.push_back(
        std::isfinite(gain)
            ? fmt::format("{} ({}): tried and not named; alone its log evidence is {:+.1f} against "
                          "no effect",
                          own.name, file, gain)
            : fmt::format("{} ({}): tried and not named; it moves nothing that was measured",
                          own.name, file));
  }
  return notes;
}

/// The two leading rivals, for what to do next about them.
Explanation rival_of(const Problem& problem, const FittedModel& model) {
  Explanation rival;
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
  const Searched searched =
      search_with_forces(prepare(std::move(built), rebuild), rebuild, options);
  const Prepared& prepared = searched.prepared;
  if (!prepared.reasons.empty()) return unanswered(prepared);

  const Problem& problem = *prepared.built.problem;
  const Selection& selection = searched.selection;
  if (selection.search.models.empty()) {
    Diagnosis out = unanswered(prepared);
    out.reasons.emplace_back("the nominal model can't be fitted to these data");
    return out;
  }

  tell(options, "held-out gap and intervals");
  const Statement statement =
      state_verdict(problem, selection, one_trial(problem.observations, problem.settings));
  Diagnosis out = answered(prepared, selection, statement);
  for (std::string& note : notes_of_own(problem, selection.search, out.effects))
    out.notes.push_back(std::move(note));
  out.remainder.places =
      places_of(searched.patterns,
                {statement.patterns, statement.pushes, problem.observations.datasets.front().model},
                share_taken(statement.gap_by_effects, statement.gap_with, problem.settings));
  tell(options, "agreement of the datasets");
  const FittedModel& account = names_effects(statement.verdict) ? statement.model : statement.none;
  out.agreement = agreement_of(problem, selection.comparison, selection.search.models.front().fit,
                               selection.search.probes, account.candidates, account.p);
  if (!prepared.built.forward || present == nullptr) return out;

  tell(options, "where the gap lies");
  out.where = localise(
      problem, *prepared.built.forward, selection, statement.stated.p, statement.posterior,
      names_effects(statement.verdict) || !statement.pushes.empty() || !statement.patterns.empty());
  out.where->postures = postures_of(problem, *prepared.built.forward, *out.noise, out.stated.p,
                                    out.model.p, out.where->departure);
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

/// The same with the horizon that the user names.
DiagnoseOptions at_horizon(DiagnoseOptions options) {
  options.settings.horizon = options.accuracy.horizon.value_or(options.settings.horizon);
  return options;
}

/// Says where a horizon was asked for that no prediction reaches.
std::string unreached(const HeldOut& gap, const std::optional<double>& horizon) {
  double reach = 0.0;
  for (const auto& [name, channel] : gap.channels)
    for (const HorizonGap& at : channel.horizons) reach = std::max(reach, at.reach);
  if (!gap.valid || !horizon || *horizon <= reach) return {};
  return fmt::format(
      "errors up to {:.3g} s were asked for, predictions end {:.3g} s after their start", *horizon,
      reach);
}

/// With what was asked, which the reports say beside what was found.
Diagnosis with_options(Diagnosis diagnosis, const DiagnoseOptions& options, Tolerances tolerances) {
  diagnosis.catalogue = options.catalogue;
  diagnosis.tolerances = std::move(tolerances);
  diagnosis.horizon = options.accuracy.horizon;
  const std::string note = unreached(diagnosis.gap, options.accuracy.horizon);
  if (!note.empty()) diagnosis.notes.push_back(note);
  return diagnosis;
}

}  // namespace

Diagnosis diagnose(const std::vector<trajectory::Dataset>& datasets,
                   const DiagnoseOptions& options) {
  const DiagnoseOptions asked = at_horizon(options);
  BuiltProblem built = build_problem(datasets, asked);
  Tolerances tolerances = read_tolerances(asked.accuracy.tolerances, built.problem->observations);
  Diagnosis out = built.forward
                      ? run_pipeline(std::move(built), builder_of(asked), &datasets.front(), asked)
                      : insufficient(*built.problem);
  describe_remainder(datasets, asked, out);
  return with_options(std::move(out), asked, std::move(tolerances));
}

Diagnosis diagnose_problem(const Problem& problem, const DiagnoseOptions& options) {
  Tolerances tolerances = read_tolerances(options.accuracy.tolerances, problem.observations);
  Problem asked = problem;
  asked.settings.horizon = options.accuracy.horizon.value_or(problem.settings.horizon);
  const bool enough =
      !problem.observations.datasets.empty() && problem.observations.insufficient.empty();
  Diagnosis out = enough ? run_pipeline({std::make_shared<const Problem>(asked), {}},
                                        builder_like(asked), nullptr, options)
                         : insufficient(problem);
  return with_options(std::move(out), options, std::move(tolerances));
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
  const Fit none = fit_model(problem, about.comparison.whitening, problem.hypotheses.nuisances(),
                             {problem.hypotheses.nominal()});
  const Fit stated = as_stated(problem, about.comparison.whitening);
  if (!none.valid || !stated.valid) return {};
  const Folds folds = folds_of(problem.observations, problem.settings);
  const OpenRows open = open_rows(problem, about.comparison, folds, none);
  const auto judged = [&](const Fit& fit) {
    return judge_fit(problem, about.comparison, folds, fit, open);
  };
  return held_out(problem, folds, judged(stated), judged(none), judged(about.fit));
}

}  // namespace jaculus::diagnosis
