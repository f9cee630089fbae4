// Localisation on leaps played by the plant, whose cause is known.

#include "jaculus/diagnosis/localise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/localise_windows.h"
#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"
#include "support/shared_data.h"

namespace jaculus {
namespace {

/// Trials of the tail leap on a changed plant, and what is localised in them.
struct Case {
  DiagnosisProblem problem;
  Localisation where;

  [[nodiscard]] const ComponentShare& share(Component c) const { return where.components[static_cast<size_t>(c)]; }
  [[nodiscard]] Component top() const {
    const auto best = std::max_element(where.components.begin(), where.components.end(),
                                       [](const auto& a, const auto& b) { return a.share < b.share; });
    return best->component;
  }
  /// Whether `c` is on top, or what is on top is said to be like it.
  [[nodiscard]] bool found(Component c) const {
    const std::vector<Component>& like = share(top()).like;
    return top() == c || std::find(like.begin(), like.end(), c) != like.end();
  }
};

Dataset play(const std::filesystem::path& data, const std::function<void(Plant&)>& change, std::uint64_t seed,
             bool joints) {
  Experiment experiment = plan_experiment(data / "plans" / "aerotail_V7_nodes82.csv", "minitaur_tail", "");
  if (!joints) std::erase_if(experiment.streams, [](const SensorStream& s) { return s.name != "mocap"; });
  const PlanarModel model = dataset_robot(experiment.setup).planar;
  Plant plant = dataset_plant(experiment.setup, model);
  change(plant);
  const Controller controller = experiment_controller(experiment, model);
  Dataset dataset = experiment.setup;
  for (int i = 0; i < 4; ++i) dataset.trials.push_back(run_trial(experiment, plant, controller, i, seed).trial);
  return dataset;
}

Case localise_leap(const std::filesystem::path& data, const std::function<void(Plant&)>& change, std::uint64_t seed = 1,
                   bool joints = true) {
  Case c;
  const std::vector<Dataset> datasets{play(data, change, seed, joints)};
  c.problem.observations = observe(datasets, {dataset_robot(datasets.front()).planar});
  std::vector<const Effect*> effects;
  for (const Effect& effect : effect_catalogue()) effects.push_back(&effect);
  const PlantForward forward = plant_forward(c.problem.observations, effects);
  c.problem.hypotheses = forward.hypotheses;
  c.problem.forward = forward.predict;
  const Linearisation about = linearise(c.problem, c.problem.hypotheses.nominal());
  EXPECT_TRUE(about.at_p.valid) << about.at_p.message;
  declare_discrepancy(c.problem, about, 0.03, 0.3);
  c.where = localise(c.problem, about, forward);
  return c;
}

std::function<void(Plant&)> with(const std::string& effect) {
  return [effect](Plant& plant) { apply_effects({read_effect(effect, plant.model, "test")}, plant); };
}

struct Single {
  std::string effect;
  Component where;
};

class SingleEffect : public ::testing::TestWithParam<Single> {};

TEST_P(SingleEffect, IsFoundInItsComponent) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Case c = localise_leap(data, with(GetParam().effect));
  RecordProperty("strength", std::to_string(c.where.strength));
  EXPECT_GT(c.where.strength, 1.2);
  EXPECT_TRUE(c.found(GetParam().where)) << component_name(c.top()) << " " << c.share(c.top()).share << " instead, gap "
                                         << c.where.strength << ", unexplained " << c.where.unexplained;
  double sum = c.where.unexplained;
  for (const ComponentShare& s : c.where.components) {
    sum += s.share;
    EXPECT_GE(s.ci95.lower, 0.0);
    EXPECT_LE(s.ci95.lower, s.ci95.upper);
  }
  EXPECT_LE(sum, 1.0 + 1e-9);
  EXPECT_FALSE(c.where.force.coordinates.empty());
  EXPECT_EQ(c.where.force.mean.cols(), c.where.force.time.size());
}

INSTANTIATE_TEST_SUITE_P(Leap, SingleEffect,
                         ::testing::Values(Single{"tail_coulomb_friction:torque=1.5", Component::tail_transmission},
                                           Single{"drag_coefficient:scale=0.5", Component::tail_aerodynamics},
                                           Single{"torque_constant:scale=0.9", Component::actuation},
                                           Single{"payload:mass=0.8", Component::body},
                                           Single{"tail_compliance:compliance=0.01", Component::tail_transmission},
                                           Single{"actuation_delay:delay=0.004", Component::actuation}),
                         [](const auto& tested) {
                           return tested.param.effect.substr(0, tested.param.effect.find(':'));
                         });

TEST(Localise, FrictionInAllLegsIsSharedByFrontAndRear) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Case c = localise_leap(data, with("leg_coulomb_friction:torque=0.3"));
  const ComponentShare &front = c.share(Component::front_legs), &rear = c.share(Component::rear_legs);
  EXPECT_GT(front.share + rear.share, 0.8);
  EXPECT_GT(front.ci95.lower, 0.1);
  EXPECT_GT(rear.ci95.lower, 0.1);
}

TEST(Localise, WithoutAnEffectNoComponentIsBlamed) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Case c = localise_leap(
        data, [](Plant&) {}, seed);
    EXPECT_LT(c.where.strength, 1.5);
    for (const ComponentShare& s : c.where.components) EXPECT_EQ(s.ci95.lower, 0.0) << component_name(s.component);
  }
}

TEST(Localise, APushIsSeenWhenItComes) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  constexpr double kStart = 0.1;
  const Case c = localise_leap(data, [](Plant& plant) { plant.pushes.push_back({kStart, 0.03, Vec2(60.0, 0.0)}); });
  ASSERT_TRUE(c.where.departure.found);
  EXPECT_NEAR(c.where.departure.time, kStart, 0.003);
  EXPECT_LE(c.where.departure.time, c.where.departure.crossing);
  double before = 0.0, at = 0.0;
  for (const RestartedWindow& w : c.where.windows) {
    if (!w.done) continue;
    const double excess = std::max(0.0, w.error * w.error - w.noise * w.noise);
    if (w.end <= kStart) before = std::max(before, excess);
    if (w.start < kStart + 0.03 && w.end > kStart) at = std::max(at, excess);
  }
  EXPECT_GT(at, 5.0 * before);
}

TEST(Localise, MotionCaptureAloneTellsLess) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const auto friction = with("tail_coulomb_friction:torque=1.5");
  const Case full = localise_leap(data, friction), mocap = localise_leap(data, friction, 1, false);
  EXPECT_LE(mocap.share(Component::tail_transmission).ci95.lower,
            full.share(Component::tail_transmission).ci95.lower + 1e-9);
  EXPECT_TRUE(std::any_of(mocap.where.notes.begin(), mocap.where.notes.end(), [](const std::string& note) {
    return note.find("motion capture alone") != std::string::npos;
  }));
}

TEST(PutOnFloor, FeetStandAndRest) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Experiment experiment = plan_experiment(data / "plans" / "aerotail_V7_nodes82.csv", "minitaur_tail", "");
  const PlanarModel model = dataset_robot(experiment.setup).planar;
  StartState s = reference_start(nominal_plant(model), experiment_controller(experiment, model).reference);
  s.q.array() += 0.004;
  s.v.setConstant(0.05);
  ASSERT_TRUE(put_on_floor(model, {0, 1}, s.q, s.v));
  const AbsoluteTree tree(model);
  Motion motion(tree);
  ASSERT_TRUE(set_configuration(tree, s.q, motion));
  set_rates(tree, s.v, motion);
  for (const int foot : {0, 1}) {
    EXPECT_NEAR(foot_position(tree, motion, foot).y(), 0.0, 1e-9);
    EXPECT_LT(foot_velocity(tree, motion, foot).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace jaculus
