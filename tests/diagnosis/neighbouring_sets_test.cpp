#include "diagnosis/selection/neighbouring_sets.h"

#include <gtest/gtest.h>

#include "diagnosis/logged_trials.h"
#include "jaculus/diagnosis/diagnose.h"

namespace jaculus::diagnosis {
namespace {

/// Friction of all joints and of each of two, and an effect of the whole robot.
Hypotheses two_joints() {
  Hypotheses hypotheses;
  for (const char* name : {"delay", "friction", "friction@elbow", "friction@shoulder"}) {
    Candidate candidate;
    candidate.name = name;
    hypotheses.candidates.push_back(candidate);
  }
  return hypotheses;
}

TEST(NeighbouringSets, WhatJointsShareIsPartedAndPutTogether) {
  const Hypotheses hypotheses = two_joints();
  EXPECT_EQ(parted_sets(hypotheses, {0, 1}, 5), (std::vector<Members>{{0, 2, 3}}));
  EXPECT_EQ(parted_sets(hypotheses, {0, 2, 3}, 5), (std::vector<Members>{{0, 1}}));
  EXPECT_TRUE(parted_sets(hypotheses, {0, 1}, 2).empty()) << "three are more than two";
  EXPECT_TRUE(parted_sets(hypotheses, {0, 2}, 5).empty()) << "one joint's part is no whole";
}

TEST(NeighbouringSets, LargerAndExchangedSetsRise) {
  EXPECT_EQ(larger_sets({1}, 3, 2), (std::vector<Members>{{0, 1}, {1, 2}}));
  EXPECT_EQ(larger_sets({1}, 3, 3), (std::vector<Members>{{0, 1}, {0, 1, 2}, {1, 2}}));
  EXPECT_EQ(exchanged_sets({0, 2}, 0, 4), (std::vector<Members>{{1, 2}, {2, 3}}));
  EXPECT_TRUE(holds_twice(two_joints(), {1, 2}));
  EXPECT_FALSE(holds_twice(two_joints(), {0, 2, 3}));
}

TEST(NeighbouringSets, WhatExtendsAnotherIsTriedWithoutItsMore) {
  Hypotheses hypotheses = two_joints();
  effects::Effect directional;
  directional.special_case = "friction@elbow";
  hypotheses.candidates.push_back({});
  hypotheses.candidates.back().name = "directional_friction@elbow";
  hypotheses.candidates.back().effect = &directional;
  EXPECT_EQ(plainer_sets(hypotheses, {0, 4}), (std::vector<Members>{{0, 2}}));
  EXPECT_TRUE(plainer_sets(hypotheses, {0, 2}).empty());
  EXPECT_TRUE(plainer_sets(hypotheses, {2, 4}).empty()) << "they stand beside one another";
}

/// Two joints that rub unlike: one value for both would be neither's.
TEST(NeighbouringSets, EachJointHasItsOwnFriction) {
  const trajectory::Dataset dataset = test::logged(
      "double_pendulum_trials.yaml", {},
      {"joint_coulomb_friction@shoulder:torque=0.06", "joint_coulomb_friction@elbow:torque=0.02"},
      4, 3);
  DiagnoseOptions options;
  options.settings.tolerances_granted =
      0;  // half a percent of the motor is more than the elbow has
  options.effects = {effects::find_effect("joint_coulomb_friction"),
                     effects::find_effect("joint_viscous_friction")};
  const Diagnosis found = diagnose({dataset}, options);
  ASSERT_EQ(found.effects.size(), 2U) << to_text(found.verdict);
  for (const FoundEffect& effect : found.effects) {
    const bool elbow = effect.name == "joint_coulomb_friction@elbow";
    EXPECT_TRUE(elbow || effect.name == "joint_coulomb_friction@shoulder") << effect.name;
    EXPECT_NEAR(effect.parameters.front().value, elbow ? 0.02 : 0.06, elbow ? 0.006 : 0.012);
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
