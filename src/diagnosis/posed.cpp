#include "diagnosis/posed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "jaculus/simulation/experiment.h"

namespace jaculus {
namespace {

constexpr int kRounds = 4;
constexpr double kStays = 0.02;       // of a prior scale
constexpr double kLateStamps = 4e-3;  // s, in the mean of the runs: twice the prior scatter of a stamp

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

/// Stamps of all streams that lie on one side of the commands: as a late start would have it, but also clocks that were set so.
void note_late_stamps(const DiagnosisProblem& problem, std::vector<std::string>& notes) {
  for (const Condition& condition : problem.observations.conditions) {
    if (condition.measured_input) continue;
    double least = kInfinity, most = -kInfinity;
    for (std::size_t s = 0; s < condition.streams.size(); ++s) {
      double mean = 0.0;
      for (const Run& run : condition.runs) mean += run.shift[s] / static_cast<double>(condition.runs.size());
      least = std::min(least, mean);
      most = std::max(most, mean);
    }
    if (least < kLateStamps && most > -kLateStamps) continue;
    notes.push_back(
        fmt::format("the motion comes {:.1f} ms {} than the stamps say, in every stream: clocks, a late start and a "
                    "common latency of the sensors look alike, so it is aligned and not counted as a gap",
                    1e3 * std::abs(0.5 * (least + most)), least > 0.0 ? "later" : "sooner"));
  }
}

std::vector<PlanarModel> robots_of(const std::vector<Dataset>& datasets) {
  std::vector<PlanarModel> models;
  for (const Dataset& dataset : datasets) models.push_back(dataset_robot(dataset).planar);
  return models;
}

}  // namespace

void tell(const DiagnoseOptions& options, const std::string& what) {
  if (options.progress) options.progress(what);
}

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
  note_late_stamps(problem, out.notes);
  return true;
}

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

Fit fit_members(const DiagnosisProblem& problem, const EvidenceSpace& space, const Vector& p,
                const std::vector<int>& members) {
  Fit model = fit_model(problem, space, problem.hypotheses.nuisances, {p});
  for (std::size_t k = 0; k < members.size() && model.valid; ++k) {
    const Probe probe = probe_candidate(problem, space, model, members[k], Screening::ladder);
    const std::vector<int> joined(members.begin(), members.begin() + static_cast<std::ptrdiff_t>(k) + 1);
    model =
        fit_model(problem, space, problem.hypotheses.freed_by(joined), fit_starts(problem, model.p, members[k], probe));
    if (k == 0) model = fit_around(problem, space, model);
  }
  return model;
}

}  // namespace jaculus
