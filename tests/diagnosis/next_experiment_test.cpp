#include "diagnosis/preflight/next_experiment.h"

#include <gtest/gtest.h>

#include "jaculus/core/installation.h"
#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {
namespace {

const std::filesystem::path kProblems = source_folder() / "problems";

/// The shipped drop, with the tail's friction made larger.
trajectory::Dataset drop_with(const Explanation& rival) {
  const simulation::Experiment experiment =
      simulation::read_experiment(kProblems / "drop_trials.yaml");
  const model::Robot robot = simulation::dataset_robot(experiment.setup);
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, robot.planar);
  rival.effects[0]->apply(rival.theta[0], plant);
  const simulation::Controller controller =
      simulation::experiment_controller(experiment, robot.planar);
  trajectory::Dataset dataset = experiment.setup;
  for (int k = 0; k < 3; ++k)
    dataset.trials.push_back(simulation::run_trial(experiment, plant, controller, k, 7).trial);
  return dataset;
}

Explanation rival(const std::string& effect, double value) {
  const effects::Effect* found = effects::find_effect(effect);
  Vector theta = found->nominal();
  theta[0] = value;
  return {{found}, {theta}};
}

TEST(NextExperiment, TellsFrictionThatDependsOnRateFromFrictionThatDoesNot) {
  const Explanation dry = rival("tail_coulomb_friction", 0.3),
                    viscous = rival("tail_viscous_friction", 0.015);
  const auto next = next_experiment(drop_with(dry), {}, {}, dry, viscous);
  ASSERT_TRUE(next);
  EXPECT_GT(next->log_bayes_factor, 3.0);
  EXPECT_TRUE(next->experiment.starts_with("tail_bench") ||
              next->experiment.starts_with("self_righting"))
      << next->experiment;
}

TEST(NextExperiment, ProposesNothingWhereRivalsAreTheSame) {
  const Explanation dry = rival("tail_coulomb_friction", 0.3);
  const auto next = next_experiment(drop_with(dry), {}, {}, dry, dry);
  EXPECT_FALSE(next) << next->experiment << ' ' << next->log_bayes_factor;
}

TEST(NextExperiment, ProposesNothingWhereNoCommandIsKnown) {
  trajectory::Dataset logged = simulation::read_experiment(kProblems / "drop_trials.yaml").setup;
  logged.controller.kind = trajectory::ControllerKind::measured;
  const Explanation dry = rival("tail_coulomb_friction", 0.3);
  EXPECT_FALSE(next_experiment(logged, {}, {}, dry, dry));
}

}  // namespace
}  // namespace jaculus::diagnosis
