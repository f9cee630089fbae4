#include "jaculus/diagnosis/diagnose.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "diagnosis/findings.h"
#include "jaculus/diagnosis/forward.h"
#include "jaculus/diagnosis/next_experiment.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus {
namespace {

void tell(const DiagnoseOptions& options, const std::string& what) {
  if (options.progress) options.progress(what);
}

/// Leaves out channels without any scatter: they were computed, not measured, or a sensor froze.
void drop_silent_channels(DiagnosisProblem& problem, std::vector<std::string>& notes) {
  for (Condition& condition : problem.observations.conditions) {
    for (std::size_t c = condition.channels.size(); c-- > 0;) {
      const Channel& channel = condition.channels[c];
      double size = 0.0;
      for (const Run& run : condition.runs)
        if (run.value[c].size() > 0) size = std::max(size, run.value[c].cwiseAbs().maxCoeff());
      if (channel.noise_floor > 1e-9 * size && channel.noise_floor > 0.0) continue;
      notes.push_back(fmt::format("{} has no scatter at all, so it is no measurement: left out", channel.name));
      drop_channel(condition, c);
    }
  }
  std::erase_if(problem.observations.conditions, [](const Condition& c) { return c.rows() == 0; });
}

/// Aligned, noise known, one-off disturbances cut; false where the data can't go on, with the reasons in `out`.
bool prepare(DiagnosisProblem& problem, Linearisation& about, const DiagnoseOptions& options, Diagnosis& out) {
  const Vector nominal = problem.hypotheses.nominal();
  tell(options, "noise and alignment");
  about = linearise(problem, nominal);
  if (!about.at_p.valid) {
    out.reasons.push_back("the nominal model can't be simulated through this experiment: " + about.at_p.message);
    return false;
  }
  out.reasons = contradictions(problem, about);
  if (!out.reasons.empty()) return false;
  const std::size_t notes = out.notes.size();
  drop_silent_channels(problem, out.notes);
  if (problem.observations.conditions.empty()) {
    out.reasons.push_back("no channel has any scatter, so nothing tells the noise");
    return false;
  }
  out.disturbances = one_off_disturbances(problem, about);
  for (const OneOff& one : out.disturbances) {
    cut(problem, one);
    const Condition& condition = problem.observations.conditions[static_cast<std::size_t>(one.condition)];
    const auto trial = static_cast<std::size_t>(condition.runs[static_cast<std::size_t>(one.run)].trial);
    out.notes.push_back(
        fmt::format("{} left the other trials at {:.3f} s (most in {}, {:.1f} times their scatter): a one-off "
                    "disturbance, its data from there on are cut out, not explained",
                    condition.dataset.trials[trial].name, one.onset, one.channel, one.excess));
  }
  if (!out.disturbances.empty() || out.notes.size() != notes) about = linearise(problem, nominal);
  return true;
}

/// The space in which models are compared; condition-wide nuisances are fitted first, and everything is linearised about them.
EvidenceSpace compare_in(DiagnosisProblem& problem, Linearisation& about, const DiagnoseOptions& options) {
  declare_discrepancy(problem, about, options.discrepancy_share, options.discrepancy_floor);
  EvidenceSpace space = evidence_space(problem, about);
  if (problem.hypotheses.nuisances.empty()) return space;
  for (int round = 0; round < 2; ++round) {
    const Fit none = fit_model(problem, space, problem.hypotheses.nuisances, {about.p});
    if (!none.valid) return space;
    Linearisation again = linearise(problem, none.p);
    if (!again.at_p.valid) return space;
    about = std::move(again);
    declare_discrepancy(problem, about, options.discrepancy_share, options.discrepancy_floor);
    space = evidence_space(problem, about);
  }
  return space;
}

/// Nuisances act differently once an effect is there (a shift on a tail that swings, the clocks by which an impact is dated): where
/// an effect leads clearly, everything is linearised about it, it is fitted again from there until it stays, and all are compared again.
constexpr double kClearLead = 10.0;  // log evidence over none
constexpr int kRounds = 4;
constexpr double kStays = 0.02;  // of a prior scale

const ModelFit* clear_leader(const Selection& selection) {
  const ModelFit* none = nullptr;
  const ModelFit* best = nullptr;
  for (const ModelFit& m : selection.models) {
    if (!m.fit.valid) continue;
    if (m.candidates.empty()) none = &m;
    if (best == nullptr || m.log_prior + m.fit.log_evidence > best->log_prior + best->fit.log_evidence) best = &m;
  }
  const bool leads = best != nullptr && none != nullptr && best->fit.log_evidence > none->fit.log_evidence + kClearLead;
  return leads ? best : nullptr;
}

void settle(DiagnosisProblem& problem, Fit& leader, Linearisation& about, EvidenceSpace& space) {
  for (int round = 0; round < kRounds; ++round) {
    Linearisation again = linearise(problem, leader.p);
    if (!again.at_p.valid) return;
    about = std::move(again);
    space = evidence_space(problem, about);
    const Fit next = fit_model(problem, space, leader.free, {leader.p});
    if (!next.valid) return;
    const Vector moved =
        problem.hypotheses.scaled(leader.free, next.p) - problem.hypotheses.scaled(leader.free, leader.p);
    leader = next;
    if (moved.cwiseAbs().maxCoeff() < kStays) return;
  }
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

std::vector<PlanarModel> robots_of(const std::vector<Dataset>& datasets) {
  std::vector<PlanarModel> models;
  for (const Dataset& dataset : datasets) models.push_back(dataset_robot(dataset).planar);
  return models;
}

/// Datasets as a problem over the effects to be compared; no forward model where observation already found them insufficient.
struct Posed {
  std::shared_ptr<DiagnosisProblem> problem = std::make_shared<DiagnosisProblem>();
  std::optional<PlantForward> forward;
};

Posed pose(const std::vector<Dataset>& datasets, const DiagnoseOptions& options) {
  Posed posed;
  posed.problem->observations = observe(datasets, robots_of(datasets), options.observation);
  if (posed.problem->observations.conditions.empty() || !posed.problem->observations.insufficient.empty()) return posed;
  std::vector<const Effect*> effects = options.effects;
  if (effects.empty())
    for (const Effect& effect : effect_catalogue()) effects.push_back(&effect);
  posed.forward = plant_forward(posed.problem->observations, effects);
  posed.problem->hypotheses = posed.forward->hypotheses;
  posed.problem->forward = posed.forward->predict;
  return posed;
}

/// All of some candidates fitted, one joining the others after another.
Fit fit_members(const DiagnosisProblem& problem, const EvidenceSpace& space, const Vector& p,
                const std::vector<int>& members) {
  std::vector<int> free = problem.hypotheses.nuisances;
  Fit model = fit_model(problem, space, free, {p});
  for (const int c : members) {
    if (!model.valid) return model;
    const auto& own = problem.hypotheses.candidates[static_cast<std::size_t>(c)].parameters;
    free.insert(free.end(), own.begin(), own.end());
    const std::vector<Probe> probes = screen(problem, space, model);
    model = fit_model(problem, space, free, fit_starts(problem, model.p, c, probes[static_cast<std::size_t>(c)]));
  }
  return model;
}

/// A rival's effects as candidates of a problem, its parameters set; effects that don't act there stay away.
FittedModel start_at(const DiagnosisProblem& problem, const Rival& rival) {
  FittedModel model{{}, problem.hypotheses.nominal()};
  for (std::size_t i = 0; i < rival.effects.size(); ++i) {
    const int c = problem.hypotheses.candidate(rival.effects[i]->name);
    if (c < 0) continue;
    model.candidates.push_back(c);
    const auto& own = problem.hypotheses.candidates[static_cast<std::size_t>(c)].parameters;
    for (std::size_t k = 0; k < own.size(); ++k) model.p[own[k]] = rival.theta[i][static_cast<Eigen::Index>(k)];
  }
  return model;
}

/// The two most probable models, for what to do next about them.
std::vector<Rival> rivals_of(const DiagnosisProblem& problem, const std::vector<FittedModel>& rivals) {
  std::vector<Rival> out;
  for (const FittedModel& model : rivals) {
    Rival rival;
    for (const int c : model.candidates) {
      const Candidate& candidate = problem.hypotheses.candidates[static_cast<std::size_t>(c)];
      Vector theta(static_cast<Eigen::Index>(candidate.parameters.size()));
      for (std::size_t k = 0; k < candidate.parameters.size(); ++k)
        theta[static_cast<Eigen::Index>(k)] = model.p[candidate.parameters[k]];
      rival.effects.push_back(candidate.effect);
      rival.theta.push_back(theta);
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
  const Selection selection = select_twice(*problem, about, space, selecting);
  if (selection.models.empty()) {
    out.reasons.push_back("the nominal model can't be fitted to these data");
    return out;
  }
  out.predictions = selection.predictions;
  tell(options, "held-out gap and intervals");
  state_findings(*problem, about, space, selection, out);
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
    if (!out.next)
      out.reasons.push_back("no experiment that could be simulated is expected to tell the two leading rivals apart");
  }
  return out;
}

std::vector<double> log_evidences(const std::vector<Dataset>& datasets, const std::vector<Rival>& rivals,
                                  const DiagnoseOptions& options) {
  DiagnoseOptions all = options;
  all.effects.clear();
  for (const Rival& rival : rivals)
    for (const Effect* effect : rival.effects)
      if (std::find(all.effects.begin(), all.effects.end(), effect) == all.effects.end()) all.effects.push_back(effect);
  std::vector<double> found(rivals.size(), kNaN);
  const Posed posed = pose(datasets, all);
  Diagnosis unused;
  Linearisation about;
  if (!posed.forward || !prepare(*posed.problem, about, options, unused)) return found;
  EvidenceSpace space = compare_in(*posed.problem, about, options);
  Linearisation there = linearise(*posed.problem, start_at(*posed.problem, rivals.front()).p);
  if (there.at_p.valid) space = evidence_space(*posed.problem, there);
  for (std::size_t r = 0; r < rivals.size(); ++r) {
    const FittedModel start = start_at(*posed.problem, rivals[r]);
    std::vector<int> free = posed.problem->hypotheses.nuisances;
    for (const int c : start.candidates) {
      const auto& own = posed.problem->hypotheses.candidates[static_cast<std::size_t>(c)].parameters;
      free.insert(free.end(), own.begin(), own.end());
    }
    const Fit anew = fit_members(*posed.problem, space, about.p, start.candidates);
    const Fit from = fit_model(*posed.problem, space, free, {start.p});
    for (const Fit* fit : {&anew, &from})
      if (fit->valid && !(fit->log_evidence < found[r])) found[r] = fit->log_evidence;
  }
  return found;
}

HeldOut held_out_with(const std::vector<Dataset>& datasets, const DiagnoseOptions& options) {
  const Posed posed = pose(datasets, options);
  DiagnosisProblem& problem = *posed.problem;
  Diagnosis unused;
  Linearisation about;
  if (!posed.forward || !prepare(problem, about, options, unused)) return {};
  EvidenceSpace space = compare_in(problem, about, options);
  std::vector<int> members;
  for (std::size_t c = 0; c < problem.hypotheses.candidates.size(); ++c) members.push_back(static_cast<int>(c));
  Fit model = fit_members(problem, space, about.p, members);
  if (!model.valid) return {};
  settle(problem, model, about, space);
  const Fit none = fit_model(problem, space, problem.hypotheses.nuisances, {problem.hypotheses.nominal()});
  return none.valid ? held_out(problem, about, none, model) : HeldOut{};
}

}  // namespace jaculus
