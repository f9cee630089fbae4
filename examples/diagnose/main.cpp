// Gives a simulated robot a fault, records trials as one would on hardware, and asks what is wrong.
// With the folder of a dataset in place of an experiment it diagnoses that.
//
//   diagnose problems/pendulum_trials.yaml joint_viscous_friction:coefficient=0.05
//   diagnose path/to/dataset

#include <cstdio>
#include <filesystem>
#include <string>

#include "jaculus/core/error.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/trajectory/dataset.h"

using namespace jaculus;

// The experiment on a robot that has an effect which its model leaves out.
trajectory::Dataset record(const std::filesystem::path& file, const std::string& effect) {
  const simulation::Experiment experiment = simulation::read_experiment(file);
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;

  simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  effects::apply_effects({effects::read_effect(effect, model, "EFFECT")}, plant);
  const simulation::Controller controller = simulation::experiment_controller(experiment, model);

  // Trials differ in their start and in the noise of their sensors.
  trajectory::Dataset dataset = experiment.setup;
  for (int i = 0; i < experiment.trials; ++i)
    dataset.trials.push_back(
        simulation::run_trial(experiment, plant, controller, i, experiment.seed).trial);
  return dataset;
}

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 3) {
    std::puts("usage: diagnose DATASET | diagnose EXPERIMENT.yaml EFFECT");
    return 2;
  }
  const trajectory::Dataset dataset =
      argc == 3 ? record(argv[1], argv[2]) : trajectory::read_dataset(argv[1]);

  // Nothing in the dataset tells the effect.
  const diagnosis::Diagnosis found = diagnosis::diagnose({dataset});
  std::printf("verdict: %s\n", to_text(found.verdict));
  for (const diagnosis::FoundEffect& effect : found.effects) {
    std::printf("  %s, probability %.2f\n", effect.name.c_str(), effect.probability);
    for (const diagnosis::FoundParameter& p : effect.parameters)
      std::printf("    %s %.4g [%.4g, %.4g] %s\n", p.name.c_str(), p.value, p.ci95.lower,
                  p.ci95.upper, p.unit.c_str());
  }
  if (found.gap.valid)
    std::printf("gap on data that the fit never saw: %.2f noise floors before, %.2f after\n",
                found.gap.before, found.gap.after);
  for (const std::string& reason : found.reasons) std::printf("  %s\n", reason.c_str());
  return 0;
} catch (const InputError& error) {
  std::printf("%s\n", error.what());
  return 2;
}
