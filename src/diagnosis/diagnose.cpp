#include "jaculus/diagnosis/diagnose.h"

#include <cstddef>
#include <numeric>

#include "diagnosis/findings.h"
#include "diagnosis/posed.h"
#include "diagnosis/posterior.h"
#include "jaculus/diagnosis/forward.h"
#include "jaculus/diagnosis/next_experiment.h"

namespace jaculus {
namespace {

constexpr double kClearLead = 10.0;  // log evidence over none, from which an effect leads clearly

const ModelFit* clear_leader(const Selection& selection) {
  const ModelFit* none = find_model(selection, {});
  const ModelFit* best = most_evident(selection);
  const bool leads = none != nullptr && best->fit.log_evidence > none->fit.log_evidence + kClearLead;
  return leads ? best : nullptr;
}

Selection select_twice(DiagnosisProblem& problem, Linearisation& about, EvidenceSpace& space,
                       const SelectionOptions& options) {
  SelectionOptions singles = options;
  singles.largest = 1;
  Selection first = select_models(problem, space, singles);
  if (first.none > 0.5 || first.models.empty()) return first;
  if (const ModelFit* clear = clear_leader(first)) {
    Fit leader = clear->fit;
    settle(problem, leader, about, space);
  }
  Selection second = select_models(problem, space, options, &first);
  second.predictions += first.predictions;
  return second;
}

bool one_trial(const DiagnosisProblem& problem) {
  int trials = 0;
  bool windows = false;
  for (const Condition& c : problem.observations.conditions) {
    trials += c.trials;
    windows = windows || c.measured_input;
  }
  return trials < 2 && !windows;
}

/// The two most probable models, for what to do next about them.
std::vector<Rival> rivals_of(const DiagnosisProblem& problem, const std::vector<FittedModel>& rivals) {
  std::vector<Rival> out;
  for (const FittedModel& model : rivals) {
    Rival rival;
    for (const int c : model.candidates) {
      const Candidate& candidate = problem.hypotheses.candidates[static_cast<std::size_t>(c)];
      rival.effects.push_back(candidate.effect);
      rival.theta.push_back(candidate.theta(model.p));
    }
    out.push_back(rival);
  }
  return out;
}

}  // namespace

Diagnosis diagnose_problem(std::shared_ptr<DiagnosisProblem> problem, const DiagnoseOptions& options) {
  Diagnosis out;
  out.verdict = "insufficient";
  out.notes = problem->observations.notes;
  out.reasons = problem->observations.insufficient;
  if (!out.reasons.empty() || problem->observations.conditions.empty()) return out;
  out.problem = problem;
  Linearisation about;
  if (!prepare(*problem, about, options, out)) return out;
  EvidenceSpace space = compare_in(*problem, about, options);
  SelectionOptions selecting = options.selection;
  selecting.progress = options.progress;
  Selection selection = select_twice(*problem, about, space, selecting);
  if (selection.models.empty()) {
    out.reasons.push_back("the nominal model can't be fitted to these data");
    return out;
  }
  out.predictions = selection.predictions;
  tell(options, "held-out gap and intervals");
  state_findings(*problem, about, space, std::move(selection), out);
  if (one_trial(*problem)) {
    out.verdict = "insufficient";
    out.reasons.push_back(
        "one trial: its noise can only be guessed from its own roughness, so no cause is stated; record three or more");
  }
  return out;
}

Diagnosis diagnose(const std::vector<Dataset>& datasets, const DiagnoseOptions& options) {
  const Posed posed = pose(datasets, options);
  if (!posed.forward) return diagnose_problem(posed.problem, options);
  Diagnosis out = diagnose_problem(posed.problem, options);
  if (!out.problem || out.p_none.size() == 0) return out;
  tell(options, "where the gap lies");
  const Linearisation about = linearise(*posed.problem, out.p_none);
  if (about.at_p.valid) out.where = localise(*posed.problem, about, *posed.forward);
  if (out.verdict == "ambiguous" && out.rivals.size() == 2) {
    tell(options, "what to do next");
    const std::vector<Rival> rivals = rivals_of(*posed.problem, out.rivals);
    out.next = next_experiment(datasets.front(), *posed.problem, rivals[0], rivals[1], options);
    if (!out.next && datasets.front().controller.kind != "measured")
      out.reasons.push_back("no experiment that could be simulated is expected to tell the two leading rivals apart");
  }
  return out;
}

HeldOut held_out_with(const std::vector<Dataset>& datasets, const DiagnoseOptions& options) {
  const Posed posed = pose(datasets, options);
  DiagnosisProblem& problem = *posed.problem;
  Diagnosis unused;
  Linearisation about;
  if (!posed.forward || !prepare(problem, about, options, unused)) return {};
  EvidenceSpace space = compare_in(problem, about, options);
  std::vector<int> members(problem.hypotheses.candidates.size());
  std::iota(members.begin(), members.end(), 0);
  Fit model = fit_members(problem, space, about.p, members);
  if (!model.valid) return {};
  settle(problem, model, about, space);
  const Fit none = fit_model(problem, space, problem.hypotheses.nuisances, {problem.hypotheses.nominal()});
  return none.valid ? held_out(problem, about, none, model) : HeldOut{};
}

}  // namespace jaculus
