#include "diagnosis/pushed_windows.h"

#include <fmt/format.h>

#include <algorithm>

#include "diagnosis/pattern_scan.h"
#include "diagnosis/remainder/events.h"
#include "diagnosis/remainder/motion_boxes.h"

namespace jaculus::diagnosis {
namespace {

/// Whether some window of its trial holds a part of a push.
bool in_a_window(const ForceEvent& push, const Observations& observations) {
  const ObservedDataset& observed = observations.datasets[push.dataset];
  return std::any_of(observed.segments.begin(), observed.segments.end(),
                     [&](const Segment& window) {
                       return observed.dataset.trials[window.trial].name == push.trial &&
                              push.from < window.end() && window.start < push.to;
                     });
}

/// A push with `margin` before and after [s]: its length is told in boxes.
TrialSpan span_of(const ForceEvent& event, const ObservedDataset& observed, double margin) {
  const std::vector<trajectory::Trial>& trials = observed.dataset.trials;
  const auto own = std::find_if(trials.begin(), trials.end(), [&](const trajectory::Trial& trial) {
    return trial.name == event.trial;
  });
  return {event.dataset, static_cast<int>(own - trials.begin()), event.from - margin,
          event.to + margin};
}

}  // namespace

std::optional<BesidePushes> beside_pushes(const Problem& problem, const ModelFit& about,
                                          const DiagnoseOptions& options) {
  std::vector<trajectory::Dataset> datasets;
  for (const ObservedDataset& observed : problem.observations.datasets)
    datasets.push_back(observed.dataset);
  const BuiltProblem all = in_boxes(datasets, options, options.settings.force_box);
  if (!all.forward ||
      all.problem->observations.datasets.size() != problem.observations.datasets.size())
    return {};
  const Vector p = carried_over({&problem, about.candidates, about.fit.p}, all.problem->hypotheses);
  std::vector<ForceEvent> pushes =
      force_events(*all.problem, motion_boxes(*all.problem, *all.forward, p));
  std::erase_if(pushes, [](const ForceEvent& push) { return push.every_trial; });
  const auto held = [&](const ForceEvent& push) { return in_a_window(push, problem.observations); };

  // Windows of a trial that holds one move, and shall not come to lie on another of its pushes.
  std::vector<TrialSpan> left_out;
  for (const ForceEvent& push : pushes)
    if (std::any_of(pushes.begin(), pushes.end(), [&](const ForceEvent& other) {
          return held(other) && other.dataset == push.dataset && other.trial == push.trial;
        }))
      left_out.push_back(
          span_of(push, problem.observations.datasets[push.dataset], options.settings.force_box));
  if (left_out.empty()) return {};

  BesidePushes beside{with_windows_beside(problem.observations, left_out, problem.settings), {}};
  for (const ForceEvent& push : pushes)
    if (held(push) && !in_a_window(push, beside.observations))
      beside.notes.push_back(
          fmt::format("{}: something seems to act once at {} from {:.2f} to {:.2f} s, about what a "
                      "first search found: effects are sought beside it",
                      push.trial, push.joint, push.from, push.to));
  if (beside.notes.empty()) return {};
  return beside;
}

}  // namespace jaculus::diagnosis
