#include "jaculus/diagnosis/next_experiment.h"

#include <gtest/gtest.h>

#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus {
namespace {

const std::filesystem::path kProblems = std::filesystem::path(JACULUS_SOURCE_DIR) / "problems";

/// The shipped drop, with the tail's friction made larger.
Dataset drop_with(const Rival& rival) {
  const Experiment experiment = read_experiment(kProblems / "drop_trials.yaml");
  const Robot robot = dataset_robot(experiment.setup);
  Plant plant = dataset_plant(experiment.setup, robot.planar);
  rival.effects[0]->apply(rival.theta[0], plant);
  const Controller controller = experiment_controller(experiment, robot.planar);
  Dataset dataset = experiment.setup;
  for (int k = 0; k < 3; ++k) dataset.trials.push_back(run_trial(experiment, plant, controller, k, 7).trial);
  return dataset;
}

Rival rival(const std::string& effect, double value) {
  const Effect* found = find_effect(effect);
  Vector theta = found->nominal();
  theta[0] = value;
  return {{found}, {theta}};
}

TEST(NextExperiment, TellsFrictionThatDependsOnRateFromFrictionThatDoesNot) {
  const Rival dry = rival("tail_coulomb_friction", 0.3), viscous = rival("tail_viscous_friction", 0.015);
  const auto next = next_experiment(drop_with(dry), {}, dry, viscous);
  ASSERT_TRUE(next);
  EXPECT_GT(next->log_bayes_factor, 5.0);
  EXPECT_TRUE(next->experiment.starts_with("tail_bench") || next->experiment.starts_with("self_righting"))
      << next->experiment;
}

TEST(NextExperiment, ProposesNothingWhereRivalsAreTheSame) {
  const Rival dry = rival("tail_coulomb_friction", 0.3);
  const auto next = next_experiment(drop_with(dry), {}, dry, dry);
  EXPECT_FALSE(next) << next->experiment << ' ' << next->log_bayes_factor;
}

TEST(NextExperiment, ProposesNothingWhereNoCommandIsKnown) {
  Dataset logged = read_experiment(kProblems / "drop_trials.yaml").setup;
  logged.controller.kind = "measured";
  const Rival dry = rival("tail_coulomb_friction", 0.3);
  EXPECT_FALSE(next_experiment(logged, {}, dry, dry));
}

}  // namespace
}  // namespace jaculus
