// Walks the catalogue and the effect of own_effect.h, unasked, for every experiment that excites an
// entry: nominal changes nothing, bit for bit; the influence goes to zero smoothly; simulated data
// give the parameter back; model values do what the plant's parameters do.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "effects/scope.h"
#include "experiments.h"
#include "jaculus/core/installation.h"
#include "jaculus/effects/check.h"
#include "jaculus/model/robot.h"
#include "own_effect.h"

namespace jaculus::effects {
namespace {

using test::Experiment;
using trajectory::ExperimentKind;

/// An effect and an experiment that excites it.
struct Walk {
  const Effect* effect;
  const Experiment* experiment;

  [[nodiscard]] std::string name() const {
    return effect->name + "_in_" + name_of(experiment->kind);
  }
};

void PrintTo(const Walk& walk, std::ostream* out) { *out << walk.name(); }

bool excites(const Experiment& experiment, const Effect& effect) {
  const auto& by = effect.excited_by;
  return std::find(by.begin(), by.end(), experiment.kind) != by.end() &&
         effect.applies(experiment.plant.model);
}

/// The catalogue's entries and an own one, in every experiment that excites them.
std::vector<Walk> walks() {
  std::vector<Walk> list;
  for (const Effect& effect : test::catalogue_with_own_effect())
    for (const Experiment& e : test::experiments())
      if (excites(e, effect)) list.push_back({&effect, &e});
  return list;
}

/// Every effect on joints, on one joint of a robot of two.
std::vector<Walk> one_joint_walks() {
  static const std::vector<Effect> on_elbow = effects_on(one_joint(other_scope(), "elbow"));

  std::vector<Walk> list;
  for (const Effect& effect : on_elbow)
    if (excites(test::two_joints(), effect)) list.push_back({&effect, &test::two_joints()});
  return list;
}

/// Measured data of a walk with an effect's parameters, in multiples of the sensors' noise; throws
/// where the simulation failed.
Vector data_with(const Walk& walk, const Vector& theta) {
  simulation::Plant plant = walk.experiment->plant;
  walk.effect->apply(theta, plant);
  std::string why;
  const auto data = test::measured_in_noise(*walk.experiment, plant, why);
  if (!data) throw std::runtime_error(fmt::format("at {}: {}", theta[0], why));
  return *data;
}

/// The same where a simulation may fail.
DataOf data_of_walk(const Walk& walk) {
  return [walk](const Vector& theta, std::string& why) {
    simulation::Plant plant = walk.experiment->plant;
    walk.effect->apply(theta, plant);
    return test::measured_in_noise(*walk.experiment, plant, why);
  };
}

double rms(const Vector& v) { return std::sqrt(v.squaredNorm() / static_cast<double>(v.size())); }

class EveryEffect : public ::testing::TestWithParam<Walk> {};

TEST_P(EveryEffect, AtNominalChangesNothing) {
  std::string why;
  const auto without =
      test::measured_in_noise(*GetParam().experiment, GetParam().experiment->plant, why);
  ASSERT_TRUE(without) << why;
  const Vector with = data_with(GetParam(), GetParam().effect->nominal());
  ASSERT_EQ(without->size(), with.size());
  for (Eigen::Index i = 0; i < with.size(); ++i)
    ASSERT_EQ((*without)[i], with[i]) << "sample " << i;
}

TEST_P(EveryEffect, FadesSmoothly) {
  const std::vector<Influence> all = influences(*GetParam().effect, data_of_walk(GetParam()));
  double before = kInfinity;
  for (const Influence& influence : all) {
    ASSERT_FALSE(std::isnan(influence.size)) << "no simulation at a share of " << influence.share;
    EXPECT_LT(influence.size, std::max(before, 1e-9)) << "at a share of " << influence.share;
    before = influence.size;
  }
  const double first = all.front().size;
  EXPECT_GT(first, 0.0) << "the experiment shows nothing of it";
  EXPECT_LT(before, 0.1 * first) << "a 64th of the step has a tenth of its influence or more";
}

/// Whether another listed experiment shows more of the effect, so that the parameter is to be had
/// there.
bool shows_most(const Walk& walk) {
  const auto influence = [](const Walk& w) {
    return (data_with(w, part_of_step(*w.effect, 0.75)) - data_with(w, w.effect->nominal())).norm();
  };
  const double own = influence(walk);
  for (const Walk& other : walks()) {
    if (other.effect == walk.effect && other.experiment != walk.experiment &&
        influence(other) > own)
      return false;
  }
  return true;
}

TEST_P(EveryEffect, GivesItsParameterBack) {
  if (!shows_most(GetParam())) GTEST_SKIP() << "shows more in another experiment, which is tested";
  const Effect& effect = *GetParam().effect;
  const Vector truth = part_of_step(effect, 0.75);
  const double departure = std::abs(truth[0] - effect.nominal()[0]);
  Vector data = data_with(GetParam(), truth);
  const DataOf predicted = data_of_walk(GetParam());
  const FirstParameter exact = fit_first(effect, predicted, data);
  EXPECT_NEAR(exact.value, truth[0], 0.01 * departure) << "without noise";
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  for (double& value : data) value += noise(random);
  const FirstParameter noisy = fit_first(effect, predicted, data);
  EXPECT_LT(noisy.deviation, 0.2 * departure) << "the experiment shows too little of it";
  EXPECT_NEAR(noisy.value, truth[0], 4.0 * noisy.deviation) << "with noise";
}

TEST_P(EveryEffect, ModelValuesDoTheSame) {
  const Effect& effect = *GetParam().effect;
  const model::PlanarModel& model = GetParam().experiment->plant.model;
  const Vector theta = part_of_step(effect, 0.75);
  const std::vector<ModelOverride> values = effect.overrides(theta, model);
  EXPECT_TRUE(effect.overrides(effect.nominal(), model).empty());
  if (values.empty()) GTEST_SKIP() << "the optimiser can't have it";
  const model::PlanarModel edited = test::with_values(*GetParam().experiment, values);
  simulation::Plant plant = GetParam().experiment->plant;
  plant.model = edited;
  plant.ground.friction = edited.friction;
  std::string why;
  const auto with_model = test::measured_in_noise(*GetParam().experiment, plant, why);
  ASSERT_TRUE(with_model) << why;
  const Vector with_plant = data_with(GetParam(), theta);
  EXPECT_LT(rms(*with_model - with_plant), 1e-3);
}

std::string test_name(const ::testing::TestParamInfo<Walk>& info) { return info.param.name(); }

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, ::testing::ValuesIn(walks()), test_name);
INSTANTIATE_TEST_SUITE_P(OneJoint, EveryEffect, ::testing::ValuesIn(one_joint_walks()), test_name);

TEST(Catalogue, EntriesAreSoundAndNamedOnce) {
  std::set<std::string> names;
  for (const Effect& effect : effect_catalogue()) {
    EXPECT_TRUE(names.insert(effect.name).second) << effect.name;
    for (const std::string& fault : effect_faults(effect)) ADD_FAILURE() << fault;
    EXPECT_EQ(find_effect(effect.name), &effect);
    EXPECT_EQ(effect.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string::npos)
        << effect.name;
  }
  EXPECT_EQ(find_effect("gremlins"), nullptr);
}

TEST(Catalogue, EveryEntryHasAnExperimentHere) {
  std::set<const Effect*> walked;
  for (const Walk& walk : walks()) walked.insert(walk.effect);
  for (const Effect& effect : test::catalogue_with_own_effect()) {
    const auto& by = effect.excited_by;
    const bool leap_alone = by == std::vector{ExperimentKind::leap};
    // needs the authors' plan
    if (leap_alone && test::experiments().front().kind != ExperimentKind::leap) continue;
    // legs that are driven directly have no gear to play
    if (effect.name == "leg_backlash") continue;
    EXPECT_TRUE(walked.count(&effect)) << effect.name;
  }
}

TEST(Catalogue, AnOwnEffectIsSoundAndTheLibraryDoesNotKnowIt) {
  const std::vector<Effect>& all = test::catalogue_with_own_effect();
  ASSERT_EQ(all.size(), effect_catalogue().size() + 1);
  EXPECT_EQ(all.back().name, "joint_lost_torque");
  EXPECT_EQ(all.back().caption, "part of the motor's torque is lost before the joints");
  EXPECT_TRUE(effect_faults(all.back()).empty());
  EXPECT_EQ(find_effect(all.back().name), nullptr);
}

TEST(Catalogue, ImpossibleEntriesAreNamed) {
  Effect effect = *find_effect("payload");
  effect.parameters[0].bounds = {1.0, 0.0};
  effect.parameters[1].scale = 0.0;
  effect.parameters[2].nominal = 7.0;
  const std::vector<std::string> faults = effect_faults(effect);
  const auto told = [&](const std::string& part) {
    return std::any_of(faults.begin(), faults.end(),
                       [&](const std::string& f) { return f.starts_with(part); });
  };
  EXPECT_TRUE(told("payload: mass: bounds [1, 0] are empty"));
  EXPECT_TRUE(told("payload: x: scale 0"));
  EXPECT_TRUE(told("payload: z: nominal 7 lies outside"));
}

std::set<std::string> names_for(const std::string& robot) {
  std::set<std::string> names;
  for (const Effect* effect :
       applicable_effects(model::read_robot(source_folder() / "models" / robot).planar))
    names.insert(effect->name);
  return names;
}

TEST(Catalogue, RobotsHaveWhatTheyCanHave) {
  const std::set<std::string> tailed = names_for("minitaur_tail"), tailless = names_for("minitaur");
  const std::set<std::string> pendulum = names_for("ak80_pendulum");
  for (const char* name :
       {"tail_compliance", "drag_coefficient", "wind", "tail_link_mass", "tail_coulomb_friction"}) {
    EXPECT_TRUE(tailed.count(name)) << name;
    EXPECT_FALSE(tailless.count(name)) << name;
    EXPECT_FALSE(pendulum.count(name)) << name;
  }
  for (const char* name :
       {"foot_friction", "leg_coulomb_friction", "payload", "battery_sag", "sensor_scale"}) {
    EXPECT_TRUE(tailed.count(name)) << name;
    EXPECT_TRUE(tailless.count(name)) << name;
    EXPECT_FALSE(pendulum.count(name)) << name;
  }
  for (const char* name : {"joint_coulomb_friction", "joint_backlash", "link_mass"}) {
    EXPECT_FALSE(tailed.count(name)) << name;
    EXPECT_TRUE(pendulum.count(name)) << name;
  }
  EXPECT_FALSE(tailed.count("leg_backlash"));  // legs are driven directly
}

}  // namespace
}  // namespace jaculus::effects
