#pragma once
// Trials of an experiment on a plant with effects: what `jaculus simulate` makes.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "jaculus/effects/select.h"
#include "jaculus/effects/user_effect.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::effects {

/// Effects as users name them.
struct EffectChoice {
  std::vector<std::string> effects;  ///< each as read_effect() takes it
  std::vector<std::string> files;    ///< of effects of the user's own, for `effects`
  std::filesystem::path augmented;   ///< augmented.yaml of a diagnosis: its effects too; or empty
  std::string effects_place = "effects";  ///< what messages call `effects`
  std::string files_place = "effect_files";
  std::vector<UserEffect> coded{};  ///< effects of a program, for `effects`
};

/// Those of `augmented`, then those of `effects`, as the robot has them. InputError as of
/// read_effect() and catalogue_with(), and where a file's effect is not named.
std::vector<EffectValue> choose_effects(const EffectChoice& choice,
                                        const model::PlanarModel& model);

/// catalogue_with() for the robots of datasets.
Catalogue catalogue_for(const std::vector<std::string>& files,
                        const std::vector<trajectory::Dataset>& datasets,
                        const std::vector<UserEffect>& coded = {});

/// What the sensors saw, and what a simulation knows of it.
struct SimulatedTrials {
  trajectory::Dataset dataset;     ///< no folder yet; trials that have a stream
  nlohmann::ordered_json summary;  ///< summary.json: every trial's end, events and figures
  bool done = true;                ///< false where a simulation did not end
};

/// Plays the experiment's trials, one after the other, until interrupt_requested(). `model` is
/// dataset_robot() of its set-up.
SimulatedTrials simulate_trials(const simulation::Experiment& experiment,
                                const std::vector<EffectValue>& effects,
                                const model::PlanarModel& model);

}  // namespace jaculus::effects
