// Pushes that every trial of a plan or script had, on the plant: told as events beside effects.

#include <gtest/gtest.h>

#include "diagnosis/effects_by_name.h"
#include "diagnosis/established_forces.h"
#include "diagnosis/toy.h"
#include "jaculus/core/installation.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/effects/effect.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kFrom = 0.11, kLength = 0.07;  // [s]

/// The shipped drop with a push along the base's x [N] and dry friction at the tail [N m].
trajectory::Dataset drop(double push, double friction) {
  simulation::Experiment experiment =
      simulation::read_experiment(source_folder() / "problems" / "drop_trials.yaml");
  for (simulation::SensorStream& stream : experiment.streams) stream.rate_hz = 240.0;
  const model::Robot robot = simulation::dataset_robot(experiment.setup);
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, robot.planar);
  simulation::Push half{kFrom, kLength, Vec2(push, 0.0)};
  half.half_sine = true;
  if (push != 0.0) plant.pushes = {half};
  if (friction != 0.0) {
    const effects::Effect* effect = effects::find_effect("tail_coulomb_friction");
    Vector theta = effect->nominal();
    theta[0] = friction;
    effect->apply(theta, plant);
  }

  const simulation::Controller controller =
      simulation::experiment_controller(experiment, robot.planar);
  trajectory::Dataset dataset = experiment.setup;
  for (int k = 0; k < 5; ++k)
    dataset.trials.push_back(simulation::run_trial(experiment, plant, controller, k, 11).trial);
  return dataset;
}

Diagnosis diagnosed(double push, double friction) {
  const DiagnoseOptions options = test::among({"tail_coulomb_friction", "wind"});
  return diagnose({drop(push, friction)}, options);
}

void expect_told(const Diagnosis& found, double push) {
  ASSERT_EQ(found.events.size(), 1U);
  const ForceEvent& event = found.events.front();
  EXPECT_EQ(event.joint, "base");
  EXPECT_EQ(event.along, "x");
  EXPECT_TRUE(event.trial.empty());
  EXPECT_NEAR(0.5 * (event.from + event.to), kFrom + 0.5 * kLength, 0.01);
  EXPECT_NEAR(event.peak, push, 0.3 * push);
  EXPECT_TRUE(event.peak_ci95.contains(event.peak));
  // Short and strong or long and weak look alike: the impulse is what data tell, as well as the
  // robot's mass is known (3 %).
  EXPECT_NEAR(event.peak * (event.to - event.from), push * kLength, 0.06 * push * kLength);
}

TEST(PushUnderAScript, IsAnEventAndNoEffect) {
  const Diagnosis found = diagnosed(10.0, 0.0);
  EXPECT_EQ(found.verdict, Verdict::none) << to_text(found.verdict);
  EXPECT_TRUE(found.effects.empty());
  expect_told(found, 10.0);
  EXPECT_LT(found.gap.after, 1.3);
  EXPECT_GT(found.gap.before, 2.0 * found.gap.after);
  for (const Ranked& row : found.ranking) EXPECT_EQ(row.effect.find("push"), std::string::npos);
}

TEST(PushUnderAScript, IsNotMadeOfAnEffect) {
  const Diagnosis found = diagnosed(0.0, 1.5);
  EXPECT_EQ(found.verdict, Verdict::effect) << to_text(found.verdict);
  EXPECT_TRUE(found.events.empty());
}

/// None, and models that lead it by so many nats, beside forces worth `lacking` nats.
SearchResult led(const std::vector<std::pair<std::vector<int>, double>>& models, double lacking) {
  SearchResult search;
  search.models.resize(1);
  for (const auto& [members, lead] : models) {
    search.models.emplace_back();
    search.models.back().candidates = members;
    search.models.back().fit.log_evidence = lead;
  }
  for (ModelFit& model : search.models) {
    model.fit.valid = true;
    if (model.candidates.empty()) model.fit.log_evidence = 0.0;
    model.fit.log_complete = model.fit.log_evidence - lacking;
  }
  return search;
}

TEST(PushUnderAScript, IsEstablishedBesideMoreOnlyWhereNoEffectExplainsAnything) {
  const std::shared_ptr<Problem> problem = test::toy_problem(test::toy_truth(0.5, 0.0));
  effects::Effect push, effect;
  push.event = true;
  problem->hypotheses.candidates[0].effect = &push;
  problem->hypotheses.candidates[1].effect = &effect;
  const auto established = [&](double lead, double lacking, double by_effects) {
    return push_established(*problem, led({{{0}, lead}}, lacking),
                            led({{{1}, by_effects}}, lacking));
  };
  EXPECT_TRUE(established(5.0, 0.0, 4.0));
  EXPECT_TRUE(established(25.0, 100.0, 0.5));
  EXPECT_FALSE(established(25.0, 100.0, 13.0));
  EXPECT_FALSE(established(8.0, 100.0, 0.5));

  // What leads is the effect beside it, which only looks so with a push among the candidates.
  const SearchResult beside = led({{{1}, 20.0}, {{0, 1}, 22.0}}, 100.0);
  EXPECT_FALSE(push_established(*problem, beside, led({}, 100.0)));
}

}  // namespace
}  // namespace jaculus::diagnosis
