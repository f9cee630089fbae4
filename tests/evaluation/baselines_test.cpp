// Baselines on a pendulum whose friction nobody told: each must name an effect.

#include "evaluation/baselines.h"

#include <gtest/gtest.h>

#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"
#include "support/temporary_folder.h"

namespace jaculus::evaluation {
namespace {

constexpr const char* kExperiment = R"(
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

/// A dataset of three trials with an effect.
std::filesystem::path trials_with(const test::TemporaryFolder& folder, const std::string& effect) {
  const simulation::Experiment experiment =
      simulation::read_experiment(folder.write("experiment.yaml", kExperiment));
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  effects::apply_effects({effects::read_effect(effect, model, "test")}, plant);
  trajectory::Dataset dataset = experiment.setup;
  const simulation::Controller controller = simulation::experiment_controller(experiment, model);
  for (int i = 0; i < experiment.trials; ++i)
    dataset.trials.push_back(simulation::run_trial(experiment, plant, controller, i, 11).trial);
  trajectory::write_dataset(dataset, folder / "data");
  return folder / "data";
}

TEST(Baselines, NameAnEffectWhereThereIsOne) {
  const test::TemporaryFolder folder;
  const auto predictions =
      evaluation::baseline_answers(trials_with(folder, "joint_coulomb_friction:torque=0.4"));
  ASSERT_EQ(predictions.size(), evaluation::baseline_names().size());
  for (const Prediction& prediction : predictions) {
    EXPECT_EQ(prediction.verdict, diagnosis::Verdict::effect);
    EXPECT_EQ(prediction.effects.size(), 1u);
    EXPECT_GT(prediction.ranking.size(), 5u);
  }
  // The lowest training error finds friction, if not its kind: the more flexible one fits as well
  // or better.
  EXPECT_TRUE(predictions[0].effects.at(0).name.ends_with("_friction"))
      << predictions[0].effects.at(0).name;
}

}  // namespace
}  // namespace jaculus::evaluation
