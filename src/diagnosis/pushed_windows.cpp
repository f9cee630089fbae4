#include "diagnosis/pushed_windows.h"

#include <fmt/format.h>

#include <algorithm>

#include "diagnosis/pattern_scan.h"
#include "diagnosis/remainder/events.h"
#include "diagnosis/remainder/motion_boxes.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kAllWindows = 1'000'000;  // of a trial

/// Pushes of one trial alone that some window of it holds a part of.
std::vector<ForceEvent> pushes_in_windows(const Problem& problem, std::vector<ForceEvent> events) {
  std::erase_if(events, [&](const ForceEvent& event) {
    if (event.every_trial) return true;
    const ObservedDataset& observed = problem.observations.datasets[event.dataset];
    return std::none_of(observed.segments.begin(), observed.segments.end(),
                        [&](const Segment& window) {
                          return observed.dataset.trials[window.trial].name == event.trial &&
                                 event.from < window.end() && window.start < event.to;
                        });
  });
  return events;
}

TrialSpan span_of(const ForceEvent& event, const ObservedDataset& observed) {
  const std::vector<trajectory::Trial>& trials = observed.dataset.trials;
  const auto own = std::find_if(trials.begin(), trials.end(), [&](const trajectory::Trial& trial) {
    return trial.name == event.trial;
  });
  return {event.dataset, static_cast<int>(own - trials.begin()), event.from, event.to};
}

}  // namespace

BuiltProblem in_boxes(const std::vector<trajectory::Dataset>& datasets, DiagnoseOptions options,
                      double box) {
  options.settings.windows = kAllWindows;
  options.settings.window_length = box;
  options.settings.window_start_half_width = 0.5 * box;
  return build_problem(datasets, options);
}

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
  const std::vector<ForceEvent> pushes = pushes_in_windows(
      problem, force_events(*all.problem, motion_boxes(*all.problem, *all.forward, p)));
  if (pushes.empty()) return {};

  std::vector<TrialSpan> left_out;
  std::vector<std::string> notes;
  for (const ForceEvent& push : pushes) {
    const ObservedDataset& observed = problem.observations.datasets[push.dataset];
    left_out.push_back(span_of(push, observed));
    notes.push_back(fmt::format(
        "{}: something acted once at {} from {:.2f} to {:.2f} s: effects are sought beside it",
        push.trial, push.joint, push.from, push.to));
  }
  return BesidePushes{with_windows_beside(problem.observations, left_out, problem.settings),
                      std::move(notes)};
}

}  // namespace jaculus::diagnosis
