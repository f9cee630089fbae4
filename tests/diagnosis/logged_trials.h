#pragma once
// Trials that were simulated, as hardware would log them.

#include <string>
#include <vector>

#include "jaculus/core/installation.h"
#include "jaculus/effects/select.h"
#include "jaculus/effects/trials.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::test {

/// Trials of a shipped experiment, under its plan.
inline trajectory::Dataset planned(const std::string& experiment,
                                   const std::vector<std::string>& files,
                                   const std::vector<std::string>& effects, int trials, int seed) {
  simulation::Experiment played =
      simulation::read_experiment(source_folder() / "problems" / experiment);
  played.trials = trials;
  played.seed = seed;
  const model::PlanarModel robot = simulation::dataset_robot(played.setup).planar;
  effects::EffectChoice choice;
  choice.effects = effects;
  choice.files = files;
  return simulate_trials(played, effects::choose_effects(choice, robot), robot).dataset;
}

/// The same as logs whose torque drives the model.
inline trajectory::Dataset logged(const std::string& experiment,
                                  const std::vector<std::string>& files,
                                  const std::vector<std::string>& effects, int trials, int seed) {
  trajectory::Dataset dataset = planned(experiment, files, effects, trials, seed);
  dataset.script.reset();
  dataset.controller = {};
  dataset.controller.kind = trajectory::ControllerKind::measured;
  dataset.controller.input = trajectory::Quantity::torque;
  return dataset;
}

}  // namespace jaculus::test
