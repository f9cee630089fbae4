// Preflights of robots of which one knows what can be told.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/diagnosis/preflight.h"
#include "jaculus/effects/effect.h"

namespace jaculus::diagnosis {
namespace {

simulation::Experiment pendulum(const std::string& torque) {
  const std::string text =
      "format: jaculus-experiment/1\nname: swing\nexperiment: pendulum\nrobot: ak80_pendulum\n"
      "input: {torque: {pendulum: " +
      torque +
      "}}\n"
      "initial: {pendulum: 0}\ncontroller: {kind: torque, rate_hz: 500}\nduration: 1.5 s\n"
      "trials: 3\nseed: 1\nstreams:\n"
      "  joints: {rate_hz: 200, channels: [\"*\", \"*_velocity\"], noise: {\"*\": 1e-3 rad, "
      "\"*_velocity\": 0.03 rad/s}}\n";
  const std::string place = (source_folder() / "problems/swing.yaml").string();
  return simulation::read_experiment(yaml::Node::parse(text, place));
}

Preflight planned(const std::string& torque, const std::vector<std::string>& effects,
                  bool alternatives = false) {
  PreflightOptions options;
  for (const std::string& name : effects)
    options.diagnosis.effects.push_back(effects::find_effect(name));
  options.alternatives = alternatives;
  return preflight(pendulum(torque), options);
}

const PlannedEffect& effect_named(const Preflight& p, const std::string& name) {
  return *std::find_if(p.effects.begin(), p.effects.end(),
                       [&](const PlannedEffect& e) { return e.name == name; });
}

const PlannedPair* pair_of(const Preflight& p, const std::string& a, const std::string& b) {
  for (const PlannedPair& pair : p.pairs)
    if ((pair.a == a && pair.b == b) || (pair.a == b && pair.b == a)) return &pair;
  return nullptr;
}

TEST(PreflightText, CountsWhatThereIsOneOf) {
  Preflight p;
  p.effects.resize(2);
  p.effects[0] = {"joint_coulomb_friction", "", "torque", "N m"};
  p.effects[0].structural = true;
  p.effects[0].least = 0.1234;
  p.effects[0].least_scales = 0.012345;
  p.effects[0].least_of_bounds = 1.2345;
  p.effects[1] = {"encoder_offset", "", "offset", "rad"};
  p.following = {{"a swing", 1.0, 1}};

  const std::string text = preflight_text(p);
  const auto has = [&text](const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has("at one probing step\n")) << text;
  EXPECT_TRUE(has("torque 0.123 N m (0.012 prior scales, 123 % of its bound)")) << text;
  EXPECT_TRUE(has("; one changes nothing that is recorded.")) << text;
  EXPECT_TRUE(has("1.00 bit, tells one pair more")) << text;
  p.size = 2.5;
  EXPECT_NE(preflight_text(p).find("at 2.5 probing steps\n"), std::string::npos);
}

TEST(Preflight, SeesNoFrictionOfAPendulumThatHangsStill) {
  const Preflight still = planned("[[0, 0], [1 s, 0]]", {"joint_viscous_friction"});
  ASSERT_TRUE(still.reasons.empty()) << still.reasons.front();
  EXPECT_FALSE(effect_named(still, "joint_viscous_friction").structural);
  EXPECT_TRUE(std::isnan(effect_named(still, "joint_viscous_friction").least));

  const Preflight moved =
      planned("[[0, 2 N m], [0.4 s, -2 N m], [1 s, 0]]", {"joint_viscous_friction"});
  const PlannedEffect& seen = effect_named(moved, "joint_viscous_friction");
  EXPECT_TRUE(seen.structural && seen.named);
  EXPECT_GT(seen.least, 0.0);
  EXPECT_LT(seen.least, seen.stated);
}

TEST(Preflight, CannotTellALinksMassFromItsMotorsTorqueConstant) {
  // Mass and inertia grow alike, so that only torque over mass enters the motion.
  const Preflight p = planned("[[0, 2 N m], [0.4 s, -2 N m], [1 s, 0]]",
                              {"link_mass", "torque_constant", "joint_viscous_friction"});
  const PlannedPair* alike = pair_of(p, "link_mass", "torque_constant");
  ASSERT_NE(alike, nullptr);
  EXPECT_FALSE(alike->tellable) << alike->told_a << ' ' << alike->told_b;
  const PlannedPair* other = pair_of(p, "link_mass", "joint_viscous_friction");
  ASSERT_NE(other, nullptr);
  EXPECT_TRUE(other->tellable) << other->told_a << ' ' << other->told_b;
  ASSERT_EQ(p.sets.size(), 1u);
  EXPECT_EQ(p.sets.front(), (std::vector<std::string>{"link_mass", "torque_constant"}));
}

TEST(Preflight, IsNotPossibleOfOneTrial) {
  simulation::Experiment one = pendulum("[[0, 2 N m], [1 s, 0]]");
  one.trials = 1;
  const Preflight p = preflight(one, {});
  ASSERT_EQ(p.reasons.size(), 1u);
  EXPECT_TRUE(p.effects.empty());
  EXPECT_EQ(preflight_sentences(p).size(), 1u);
}

}  // namespace
}  // namespace jaculus::diagnosis
