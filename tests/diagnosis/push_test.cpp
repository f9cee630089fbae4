// Pushes that every trial of a plan or script had, on the plant: told as events beside effects.

#include <gtest/gtest.h>

#include "diagnosis/effects_by_name.h"
#include "diagnosis/forward/problem.h"
#include "jaculus/core/installation.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/summary.h"
#include "jaculus/effects/effect.h"
#include "jaculus/effects/user_effect.h"
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

/// What is left follows the time, at the push's place; its file is an effect the robot can have.
void expect_left(const Diagnosis& found) {
  ASSERT_EQ(found.remainder.places.size(), 1U);
  const RemainderPlace& place = found.remainder.places.front();
  EXPECT_EQ(place.place, "body");
  EXPECT_EQ(place.joint, "x");
  EXPECT_EQ(place.unit, "N");
  ASSERT_EQ(place.follows.size(), 1U);
  EXPECT_EQ(place.follows.front().regressor, Regressor::time);
  EXPECT_GT(place.follows.front().share, 0.5);
  const model::PlanarModel& robot = found.problem->observations.datasets.front().model;
  EXPECT_NO_THROW(
      effects::parse_user_effect(place.follows.front().hypothesis, "push.yaml").require(robot));

  EXPECT_TRUE(remainder_sentences(found).empty());  // it is told among the events
  EXPECT_TRUE(leading_remainder(found).empty());
}

TEST(PushUnderAScript, IsAnEventAndNoEffect) {
  const Diagnosis found = diagnosed(10.0, 0.0);
  EXPECT_EQ(found.verdict, Verdict::unexplained) << to_text(found.verdict);
  EXPECT_TRUE(found.effects.empty());
  expect_told(found, 10.0);
  expect_left(found);
  EXPECT_LT(found.gap.after, 1.3);
  EXPECT_GT(found.gap.before, 2.0 * found.gap.after);
  for (const Ranked& row : found.ranking) EXPECT_EQ(row.effect.find("push"), std::string::npos);
}

TEST(PushUnderAScript, IsNotMadeOfAnEffect) {
  const Diagnosis found = diagnosed(0.0, 1.5);
  EXPECT_EQ(found.verdict, Verdict::effect) << to_text(found.verdict);
  EXPECT_TRUE(found.events.empty());
}

}  // namespace
}  // namespace jaculus::diagnosis
