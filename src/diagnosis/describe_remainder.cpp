#include "diagnosis/describe_remainder.h"

#include <algorithm>

#include "diagnosis/build_problem.h"
#include "diagnosis/motion_patterns.h"
#include "diagnosis/remainder/box_states.h"
#include "diagnosis/remainder/events.h"
#include "diagnosis/remainder/remainder.h"

namespace jaculus::diagnosis {
namespace {

/// Whether a trial logs the torque of every motor.
bool logs_torques(const trajectory::Trial& trial, const model::PlanarModel& robot) {
  return std::all_of(
      robot.motors.begin(), robot.motors.end(), [&](const model::PlanarMotor& motor) {
        return std::any_of(
            trial.streams.begin(), trial.streams.end(), [&](const trajectory::Stream& stream) {
              return stream.channel(channel_name(motor.joint, trajectory::Quantity::torque)) >= 0;
            });
      });
}

/// Datasets as logs whose torques drive the model; none where one lacks a motor's torque, or where
/// feet pass forces on that nothing measures.
std::vector<trajectory::Dataset> as_logged(std::vector<trajectory::Dataset> datasets,
                                           const Observations& observations) {
  for (const ObservedDataset& observed : observations.datasets)
    if (!observed.model.feet.empty() || observed.model.motors.empty()) return {};
  const model::PlanarModel& robot = observations.datasets.front().model;
  for (trajectory::Dataset& dataset : datasets) {
    if (dataset.controller.kind == trajectory::ControllerKind::measured) continue;
    for (const trajectory::Trial& trial : dataset.trials)
      if (!logs_torques(trial, robot)) return {};
    dataset.plan.reset();
    dataset.script.reset();
    dataset.controller = {};
    dataset.controller.kind = trajectory::ControllerKind::measured;
    dataset.controller.input = trajectory::Quantity::torque;
  }
  return datasets;
}

std::vector<std::vector<MotionBox>> boxes_about(const Diagnosis& found, const BuiltProblem& all) {
  return motion_boxes(*all.problem, *all.forward,
                      stated_parameters(found, all.problem->hypotheses));
}

/// Where every motor's torque is logged and nothing touches the ground.
std::vector<RemainderPlace> places_in_boxes(const std::vector<trajectory::Dataset>& datasets,
                                            const DiagnoseOptions& options,
                                            const Diagnosis& found) {
  const Observations& observations = found.problem->observations;
  const std::vector<trajectory::Dataset> logged = as_logged(datasets, observations);
  if (logged.empty()) return {};
  const BuiltProblem fine =
      in_boxes(logged, options, pattern_box(observations.datasets, options.settings));
  if (!fine.forward) return {};
  return described_places(*fine.problem, boxes_about(found, fine));
}

}  // namespace

void describe_remainder(const std::vector<trajectory::Dataset>& datasets,
                        const DiagnoseOptions& options, Diagnosis& found) {
  if (found.problem == nullptr || found.none.p.size() == 0) return;
  set_share(found.gap, found.settings, found.remainder);
  if (in_windows(*found.problem)) {
    if (options.progress) options.progress("events");
    const BuiltProblem all = in_boxes(datasets, options, options.settings.force_box);
    if (!all.forward) return;
    for (ForceEvent& event : force_events(*all.problem, boxes_about(found, all)))
      found.events.push_back(event);
  }

  if (options.progress) options.progress("what is left");
  std::vector<RemainderPlace>& places = found.remainder.places;
  // What the search told of simulated forces, boxes would find again.
  if (places.empty()) places = places_in_boxes(datasets, options, found);
  const bool followed = std::any_of(places.begin(), places.end(), [](const RemainderPlace& p) {
    return !p.follows.empty() && !p.is_push();
  });
  if (followed) return;
  for (RemainderPlace& place : patterns_of_motion(found)) places.push_back(std::move(place));
}

}  // namespace jaculus::diagnosis
