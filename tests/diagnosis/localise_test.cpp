// Localisation on leaps played by the plant, whose cause is known.

#include "diagnosis/localise/localise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/localise/components.h"
#include "diagnosis/localise/windows.h"
#include "diagnosis/noise/noise_model.h"
#include "diagnosis/validation/shapley.h"
#include "jaculus/core/installation.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/diagnosis_json.h"
#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"
#include "support/shared_data.h"

namespace jaculus::diagnosis {
namespace {

/// Trials of the tail leap on a changed plant, and what is localised in them.
struct Case {
  Localisation where;
  Diagnosis diagnosis;

  [[nodiscard]] const ComponentShare& share(effects::Component c) const {
    return where.components[static_cast<std::size_t>(c)];
  }
  [[nodiscard]] effects::Component top() const {
    const auto best =
        std::max_element(where.components.begin(), where.components.end(),
                         [](const auto& a, const auto& b) { return a.share < b.share; });
    return best->component;
  }
  /// Whether `c` is on top, or what is on top is said to be like it.
  [[nodiscard]] bool found(effects::Component c) const {
    const std::vector<effects::Component>& like = share(top()).indistinguishable;
    return top() == c || std::find(like.begin(), like.end(), c) != like.end();
  }
};

trajectory::Dataset play(const std::filesystem::path& data,
                         const std::function<void(simulation::Plant&)>& change, std::uint64_t seed,
                         bool joints) {
  simulation::Experiment experiment =
      simulation::plan_experiment(data / "plans" / "aerotail_V7_nodes82.csv", "minitaur_tail", "");
  if (!joints)
    std::erase_if(experiment.streams,
                  [](const simulation::SensorStream& s) { return s.name != "mocap"; });
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  change(plant);
  const simulation::Controller controller = simulation::experiment_controller(experiment, model);
  trajectory::Dataset dataset = experiment.setup;
  for (int i = 0; i < 4; ++i)
    dataset.trials.push_back(simulation::run_trial(experiment, plant, controller, i, seed).trial);
  return dataset;
}

/// One effect or two of every component, so that a search takes seconds.
std::vector<const effects::Effect*> candidates() {
  std::vector<const effects::Effect*> list;
  for (const char* name :
       {"tail_coulomb_friction", "tail_compliance", "drag_coefficient", "torque_constant",
        "actuation_delay", "leg_coulomb_friction", "foot_friction", "payload", "sensor_latency"})
    list.push_back(effects::find_effect(name));
  std::erase(list, nullptr);
  return list;
}

Case localise_leap(const std::filesystem::path& data,
                   const std::function<void(simulation::Plant&)>& change, std::uint64_t seed = 1,
                   bool joints = true) {
  DiagnoseOptions options;
  options.effects = candidates();
  options.settings.largest_model = 1;  // pairs would take minutes
  const Diagnosis d = diagnose({play(data, change, seed, joints)}, options);
  EXPECT_TRUE(d.where) << diagnosis_text(d);
  return {d.where.value_or(Localisation{}), d};
}

std::function<void(simulation::Plant&)> with(const std::string& effect) {
  return [effect](simulation::Plant& plant) {
    effects::apply_effects({effects::read_effect(effect, plant.model, "test")}, plant);
  };
}

struct Single {
  std::string effect;
  effects::Component where;
};

class SingleEffect : public ::testing::TestWithParam<Single> {};

TEST_P(SingleEffect, IsFoundInItsComponent) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Case c = localise_leap(data, with(GetParam().effect));
  RecordProperty("strength", std::to_string(c.where.strength));
  EXPECT_GT(c.where.strength, 1.2);
  EXPECT_TRUE(c.found(GetParam().where))
      << effects::component_name(c.top()) << " " << c.share(c.top()).share << " instead, gap "
      << c.where.strength << ", unexplained " << c.where.unexplained;
  // One posterior: what the verdict names is where the gap lies.
  if (c.diagnosis.verdict == Verdict::effect) {
    EXPECT_TRUE(effects::find_effect(c.diagnosis.effects.front().name)->acts_in(c.top()));
  }
  // One noise model: the floor that a page shows is the one that the gap is judged by.
  const std::vector<ChannelNoise>& judged = c.diagnosis.noise->datasets.front().channels;
  ASSERT_EQ(c.where.channels.size(), judged.size());
  for (std::size_t i = 0; i < judged.size(); ++i)
    EXPECT_NEAR(c.where.channels[i].noise_floor / judged[i].noise_floor, 1.0, 1e-9)
        << c.where.channels[i].name;
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

INSTANTIATE_TEST_SUITE_P(
    Leap, SingleEffect,
    ::testing::Values(
        Single{"tail_coulomb_friction:torque=1.5", effects::Component::tail_transmission},
        Single{"drag_coefficient:scale=0.5", effects::Component::tail_aerodynamics},
        Single{"torque_constant:scale=0.9", effects::Component::actuation},
        Single{"payload:mass=0.8", effects::Component::body},
        Single{"tail_compliance:compliance=0.01", effects::Component::tail_transmission},
        Single{"actuation_delay:delay=0.004", effects::Component::actuation}),
    [](const auto& tested) {
      return tested.param.effect.substr(0, tested.param.effect.find(':'));
    });

TEST(Localise, FrictionInAllLegsIsSharedByFrontAndRear) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Case c = localise_leap(data, with("leg_coulomb_friction:torque=0.3"));
  const ComponentShare &front = c.share(effects::Component::front_legs),
                       &rear = c.share(effects::Component::rear_legs);
  EXPECT_GT(front.share + rear.share, 0.8);
  EXPECT_GT(front.ci95.lower, 0.1);
  EXPECT_GT(rear.ci95.lower, 0.1);
}

TEST(Localise, ARobotOnASlideHasNoLegsAndNoTail) {
  const simulation::Experiment experiment =
      simulation::read_experiment(source_folder() / "problems" / "slider_trials.yaml");
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  with("joint_coulomb_friction:torque=0.1")(plant);
  const simulation::Controller controller = simulation::experiment_controller(experiment, model);
  trajectory::Dataset dataset = experiment.setup;
  for (int i = 0; i < 3; ++i)
    dataset.trials.push_back(simulation::run_trial(experiment, plant, controller, i, 1).trial);

  DiagnoseOptions options;
  options.settings.largest_model = 1;
  const Diagnosis d = diagnose({dataset}, options);
  ASSERT_TRUE(d.where) << diagnosis_text(d);
  for (const ComponentShare& s : d.where->components) {
    const std::string name = effects::component_name(s.component);
    EXPECT_EQ(s.present, name == "actuation" || name == "body" || name == "sensing") << name;
  }
  for (const std::string& note : d.where->notes) {
    EXPECT_EQ(note.find("tail"), std::string::npos) << note;
    EXPECT_EQ(note.find("legs"), std::string::npos) << note;
  }
}

TEST(Localise, WithoutAnEffectNoComponentIsBlamed) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Case c = localise_leap(
        data, [](simulation::Plant&) {}, seed);
    EXPECT_LT(c.where.strength, 1.5);
    for (const ComponentShare& s : c.where.components)
      EXPECT_EQ(s.ci95.lower, 0.0) << effects::component_name(s.component);
  }
}

TEST(Localise, APushIsSeenWhenItComes) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  constexpr double kStart = 0.1;
  const Case c = localise_leap(data, [](simulation::Plant& plant) {
    plant.pushes.push_back({kStart, 0.03, Vec2(60.0, 0.0)});
  });
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
  EXPECT_LE(mocap.share(effects::Component::tail_transmission).ci95.lower,
            full.share(effects::Component::tail_transmission).ci95.lower + 1e-9);
  EXPECT_TRUE(
      std::any_of(mocap.where.notes.begin(), mocap.where.notes.end(), [](const std::string& note) {
        return note.find("motion capture alone") != std::string::npos;
      }));
}

TEST(Localise, ASlipperyFloorIsInTheContact) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Case c = localise_leap(data, with("foot_friction:scale=0.4"));
  ASSERT_EQ(c.diagnosis.verdict, Verdict::effect) << diagnosis_text(c.diagnosis);
  EXPECT_EQ(c.diagnosis.effects.front().name, "foot_friction");
  EXPECT_GT(c.share(effects::Component::contact).share, 0.8);
}

TEST(Shapley, SharesAGloveGame) {
  // Players 0 and 1 hold a left glove each, player 2 the right one: a pair is worth 1.
  std::vector<double> worth(8, 0.0);
  for (unsigned subset = 0; subset < 8; ++subset)
    worth[subset] = (subset & 4U) != 0U && (subset & 3U) != 0U ? 1.0 : 0.0;
  const Vector value = shapley_values(worth, 3);
  EXPECT_NEAR(value[0], 1.0 / 6.0, 1e-12);
  EXPECT_NEAR(value[1], 1.0 / 6.0, 1e-12);
  EXPECT_NEAR(value[2], 2.0 / 3.0, 1e-12);
}

TEST(PutOnFloor, FeetStandAndRest) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const simulation::Experiment experiment =
      simulation::plan_experiment(data / "plans" / "aerotail_V7_nodes82.csv", "minitaur_tail", "");
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  simulation::StartState s =
      simulation::reference_start(simulation::nominal_plant(model),
                                  simulation::experiment_controller(experiment, model).reference);
  s.q.array() += 0.004;
  s.v.setConstant(0.05);
  ASSERT_TRUE(put_on_floor(model, {0, 1}, s.q, s.v));
  const dynamics::AbsoluteTree tree(model);
  dynamics::Motion motion(tree);
  ASSERT_TRUE(dynamics::set_configuration(tree, s.q, motion));
  dynamics::set_rates(tree, s.v, motion);
  for (const int foot : {0, 1}) {
    EXPECT_NEAR(dynamics::foot_position(tree, motion, foot).y(), 0.0, 1e-9);
    EXPECT_LT(dynamics::foot_velocity(tree, motion, foot).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
