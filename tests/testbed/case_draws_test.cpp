// What a blinded case is made of: names, strengths and, of a push, its moment.

#include "testbed/case_draws.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "support/input_error.h"
#include "testbed/both_engines.h"
#include "testbed/labels.h"

namespace jaculus::testbed {
namespace {

using test::holds;
using test::input_error_of;
using test::kModels;
using Strings = std::vector<std::string>;

/// Friction that stands in for a push at one joint: it shows, and grows with the peak.
BenchEffect push_at(const std::string& joint) {
  BenchEffect push;
  push.name = "joint_push@" + joint;
  push.outside = push.event = true;
  push.joint = joint;
  push.parameters = {{"peak", "N m", 0.0, -3.0, 3.0},
                     {"start", "s", 0.1, 0.0, 30.0, true},
                     {"length", "s", 0.1, 0.05, 0.5, true}};
  push.experiments = {trajectory::ExperimentKind::pendulum};
  push.apply = [](const std::vector<double>& v, Changes& c) {
    c.leg_friction.viscous = std::abs(v[0]);
  };
  return push;
}

Grounds drop_grounds() {
  Grounds grounds;
  grounds.stages = {make_stage("drop", self_righting(kModels / "minitaur_tail"))};
  grounds.pool = pool_of(grounds.stages, {});
  return grounds;
}

/// A swing on which a made-up push can act at two joints.
Grounds pushed_grounds() {
  Grounds grounds;
  Stage stage = make_stage("swing", swing(kModels / "double_pendulum", SwingInput::torque));
  std::erase_if(stage.effects, [](const BenchEffect& effect) { return effect.event; });
  for (const char* joint : {"shoulder", "elbow"}) stage.effects.push_back(push_at(joint));
  grounds.stages = {stage};
  grounds.pool = pool_of(grounds.stages, {});
  return grounds;
}

TEST(CaseDraws, EffectsOfACaseActOnDifferentParts) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const Grounds grounds = drop_grounds();
  Random random(7);
  std::set<std::size_t> counts;
  for (int i = 0; i < 60; ++i) {
    const Strings effects = draw_effects(random, {"several"}, grounds);
    counts.insert(effects.size());
    std::set<std::string> parts;
    for (const std::string& name : effects) parts.insert(grounds.pool.components.at(name));
    EXPECT_EQ(parts.size(), effects.size());
    EXPECT_EQ(draw_effects(random, {"pair"}, grounds).size(), 2U);
  }
  EXPECT_EQ(counts, (std::set<std::size_t>{2, 3}));
}

TEST(CaseDraws, AnEffectAtOneJointIsDrawnAsOftenAsAnotherEffect) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  Grounds grounds = pushed_grounds();
  grounds.pool.events.push_back({"base_push"});
  grounds.pool.components["base_push"] = "";
  BenchEffect base = push_at("");
  base.name = "base_push";
  grounds.stages.front().effects.push_back(base);
  Random random(5);
  int of_joints = 0;
  for (int i = 0; i < 400; ++i)
    of_joints += draw_effects(random, {"event"}, grounds).front() == "base_push" ? 0 : 1;
  // half of 400, within four standard deviations of 10
  EXPECT_NEAR(of_joints, 200, 40);
}

TEST(CaseDraws, WithheldPushesAndKindsWithoutEffectsAreSaid) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  Grounds grounds = pushed_grounds();
  grounds.pool = pool_of(grounds.stages, {"joint_push@elbow"});
  Random random(2);
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(draw_effects(random, {"event"}, grounds), Strings{"joint_push@shoulder"});
  grounds.pool = pool_of(grounds.stages, {"joint_push"});
  EXPECT_TRUE(
      holds(input_error_of([&] { check_kind({"event"}, grounds); }), "cases of kind 'event'"));
  EXPECT_TRUE(holds(input_error_of([&] {
                      check_kind({"single", true}, grounds);
                    }),
                    "in groups"))
      << "one experiment is no group";
}

TEST(CaseDraws, APushFallsWithinTheCommandsAndItsLabelSaysWhen) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const Grounds grounds = pushed_grounds();
  const Stage& stage = grounds.stages.front();
  const double end = commands_end(stage);
  const BenchEffect& effect = *acting_effect(stage, "joint_push@elbow");
  Random random(11);
  int forward = 0;
  for (int i = 0; i < 200; ++i) {
    double side = 0.0;
    Dose dose = draw_dose(effect, stage, random, side);
    forward += side > 0.0 ? 1 : 0;
    dose.values[0] = 0.5 * side;
    const TrueEvent event = event_of(dose, end);
    EXPECT_EQ(event.joint, "elbow");
    EXPECT_GE(event.from, 0.0);
    EXPECT_LE(event.to, end);
    EXPECT_NEAR(event.to - event.from, dose.values[2], 1e-12);
    EXPECT_GE(dose.values[2], 0.05);
    EXPECT_EQ(event.peak, 0.5 * side);
  }
  EXPECT_NEAR(forward, 100, 40) << "either way alike";

  Dose late{&effect, {1.0, end - 0.02, 0.1}};
  EXPECT_DOUBLE_EQ(event_of(late, end).to, end);
}

TEST(CaseDraws, ACaseOfAPushHoldsNothingElse) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  Grounds grounds = pushed_grounds();
  grounds.signatures = {signatures_of(grounds.stages.front(), {})};
  const MadeCase made = draw_case({"event"}, 21, grounds);
  EXPECT_EQ(made.label.kind, "event");
  ASSERT_EQ(made.label.events.size(), 1U);
  ASSERT_EQ(made.label.effects.size(), 1U);
  EXPECT_EQ(made.label.effects.front(), "joint_push@" + made.label.events.front().joint);
  EXPECT_EQ(made.label.parameters.front().front(), made.label.events.front().peak);
  EXPECT_TRUE(made.label.beside.empty());
  EXPECT_EQ(made.datasets.size(), 1U);
  EXPECT_GE(made.label.strength_in_noise_floors, 0.7);
}

TEST(Labels, ComeBackFromText) {
  CaseLabel label;
  label.case_id = "case_1";
  label.kind = "event";
  label.effects = {"joint_push@elbow"};
  label.parameters = {{1.5, kNaN}};
  label.datasets = 3;
  label.events = {{"elbow", 0.25, 0.5, -1.5}, {"base", 0.0, 0.1, 20.0}};
  const CaseLabel read = labels_in(sealed_text({label_text(label)}, "a test"), nullptr).front();
  EXPECT_EQ(label_text(read), label_text(label));
  EXPECT_EQ(read.datasets, 3);
  ASSERT_EQ(read.events.size(), 2U);
  EXPECT_EQ(read.events[0].joint, "elbow");
  EXPECT_EQ(read.events[0].from, 0.25);
  EXPECT_EQ(read.events[0].to, 0.5);
  EXPECT_EQ(read.events[0].peak, -1.5);
}

}  // namespace
}  // namespace jaculus::testbed
