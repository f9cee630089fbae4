#pragma once
// Three trials of a pendulum under a script of torques, with an effect of the catalogue or without.

#include <filesystem>
#include <string>

#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"
#include "support/temporary_folder.h"

namespace jaculus::evaluation {

inline constexpr const char* kSwing = R"(
format: jaculus-experiment/1
name: swing
experiment: pendulum
robot: ak80_pendulum
input: {torque: {pendulum: [[0, 1.5], [0.25, -1.5], [0.5, 0]]}}
initial: {pendulum: 0}
controller: {kind: torque, rate_hz: 500}
duration: 0.6 s
trials: 3
streams:
  joints: {rate_hz: 100, channels: ["*", "*_velocity"], noise: {"*": 1e-3, "*_velocity": 0.02}}
)";

/// The folder of a dataset of three trials with an effect, if any.
inline std::filesystem::path trials_with(const test::TemporaryFolder& folder,
                                         const std::string& effect) {
  const simulation::Experiment experiment =
      simulation::read_experiment(folder.write("experiment.yaml", kSwing));
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  if (!effect.empty()) effects::apply_effects({effects::read_effect(effect, model, "test")}, plant);
  trajectory::Dataset dataset = experiment.setup;
  const simulation::Controller controller = simulation::experiment_controller(experiment, model);
  for (int i = 0; i < experiment.trials; ++i)
    dataset.trials.push_back(simulation::run_trial(experiment, plant, controller, i, 11).trial);
  trajectory::write_dataset(dataset, folder / "data");
  return folder / "data";
}

}  // namespace jaculus::evaluation
