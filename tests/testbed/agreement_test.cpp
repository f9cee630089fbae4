// Two engines that share no physics: the plant (rigid contact found as events, minimal coordinates)
// and MuJoCo (soft contact, pins as constraints, left and right legs). With no effect, leap and
// drop must agree to less than half the noise floor of motion capture (0.3 mm, 0.15 deg); with an
// effect, both must show the same gap.

#include <gtest/gtest.h>

#include "jaculus/testbed/playback.h"
#include "support/shared_data.h"
#include "testbed/both_engines.h"
#include "testbed/commands.h"
#include "testbed/draws.h"
#include "testbed/mjcf.h"

namespace jaculus::testbed {
namespace {

using test::expect_agreement;
using test::expect_the_same_gap;
using test::kModels;

TEST(Agreement, LeapsOfThreePlansByTorqueAndByDuty) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  JACULUS_REQUIRE_SHARED_DATA(data);
  for (const std::string plan : {"notail_V7", "aerotail_V7_nodes82", "inactivetail_V7"}) {
    for (const auto quantity : {trajectory::Quantity::torque, trajectory::Quantity::duty}) {
      SCOPED_TRACE(plan + " " + name_of(quantity));
      const auto robot = kModels / (plan == "notail_V7" ? "minitaur" : "minitaur_tail");
      expect_agreement(testbed::leap(robot, data / "plans" / (plan + ".csv"), quantity), 0.08);
    }
  }
}

/// Contacts that rattle unload one foot of a pair at random, and a leg near its shortest then goes
/// another way than its twin.
TEST(Testbed, KeepsLeftAndRightLegsTogetherWhateverTheEncodersSay) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  JACULUS_REQUIRE_SHARED_DATA(data);
  const testbed::RobotFiles files = testbed::read_robot_files(kModels / "minitaur_tail");
  const trajectory::Dataset asked =
      testbed::leap(kModels / "minitaur_tail", data / "plans" / "inactivetail_V7.csv",
                    trajectory::Quantity::torque);
  testbed::PlanCommands plan =
      testbed::plan_commands(*asked.plan, files, trajectory::Quantity::torque, "plan.csv");
  for (const std::string& motor : plan.commands.motors) {
    plan.commands.kp[motor] = asked.controller.kp.at(motor).range.lower;
    plan.commands.kd[motor] = asked.controller.kd.at(motor).range.lower;
  }
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    testbed::PlayOptions options;
    options.start = plan.start;
    options.duration = plan.duration;
    options.level = true;
    options.sensors = {1e-4, 5e-4, 0.03, seed};
    const testbed::Recording r =
        testbed::play(files, {}, plan.commands, options, testbed::Numerics{});
    ASSERT_FALSE(r.diverged);
    for (int i = 1; i < count_of(r.motors); ++i) {
      if (r.motor_of[i] != r.motor_of[i - 1]) continue;
      EXPECT_LT((r.position.row(i) - r.position.row(i - 1)).cwiseAbs().maxCoeff(), 2e-3)
          << seed << r.motors[i];
    }
  }
}

TEST(Testbed, SaysWhereSlippingFeetPartLeftAndRightLegs) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  JACULUS_REQUIRE_SHARED_DATA(data);
  const trajectory::Dataset asked =
      testbed::leap(kModels / "minitaur_tail", data / "plans" / "inactivetail_V7.csv",
                    trajectory::Quantity::duty);
  testbed::TrialSpec spec;
  spec.trials = 2;
  double apart = 0.0;
  testbed::run_trials(asked, {}, spec, &apart);
  EXPECT_LT(apart, 5e-3);
  testbed::Changes slippery;
  slippery.floor_friction_scale = 0.43;
  testbed::run_trials(asked, slippery, spec, &apart);
  EXPECT_GT(apart, 0.1);
}

TEST(Testbed, StrengthLeavesOutWhatAnotherStartWouldDo) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  const testbed::Stage stage =
      testbed::make_stage("self_righting", testbed::self_righting(kModels / "minitaur_tail"));
  const testbed::Signatures signatures = testbed::signatures_of(stage, {});
  testbed::TrialSpec spec, moved;
  moved.start_offset["tail"] = 1e-3;
  const trajectory::Dataset nominal = *testbed::exact_run(stage, {}, spec);
  EXPECT_LT(testbed::share_beyond_nuisances(stage, signatures, spec, nominal,
                                            *testbed::exact_run(stage, {}, moved)),
            0.1);
  testbed::Changes friction;
  friction.tail_friction.coulomb = 0.3;
  EXPECT_GT(testbed::share_beyond_nuisances(stage, signatures, spec, nominal,
                                            *testbed::exact_run(stage, friction, spec)),
            0.5);
}

TEST(Agreement, SelfRightingDropThroughTheStop) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  expect_agreement(testbed::self_righting(kModels / "minitaur_tail"), 0.0);
}

struct Pair {
  const char* effect;
  double value;
};

class EffectAgreement : public ::testing::TestWithParam<Pair> {};

TEST_P(EffectAgreement, TheSameNumberMakesTheSameGap) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  JACULUS_REQUIRE_SHARED_DATA(data);
  const trajectory::Dataset asked =
      testbed::leap(kModels / "minitaur_tail", data / "plans" / "aerotail_V7_nodes82.csv",
                    trajectory::Quantity::duty);
  expect_the_same_gap(asked, GetParam().effect, GetParam().value, 0.05);
}

INSTANTIATE_TEST_SUITE_P(
    Catalogue, EffectAgreement,
    ::testing::Values(Pair{"tail_compliance", 0.01}, Pair{"tail_coulomb_friction", 2.0},
                      Pair{"leg_coulomb_friction", 0.1}, Pair{"leg_viscous_friction", 0.01},
                      Pair{"leg_load_friction", 0.1}, Pair{"torque_constant", 0.93},
                      Pair{"voltage_limit", 0.1}, Pair{"battery_sag", 0.03},
                      Pair{"winding_heating", 30.0}, Pair{"drag_coefficient", 1.8},
                      Pair{"drag_without_translation", 1.0}, Pair{"wind", 1.5},
                      Pair{"leg_rotor_inertia", 3e-4}, Pair{"tail_link_mass", 1.25},
                      Pair{"leg_link_inertia", 2.0}, Pair{"payload", 0.5}, Pair{"com_shift", 0.015},
                      Pair{"body_inertia", 1.9}, Pair{"foot_radius", 0.005}),
    [](const auto& info) { return std::string(info.param.effect); });

}  // namespace
}  // namespace jaculus::testbed
