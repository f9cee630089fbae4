// A leap planned again with a payload known: the robot that carries it keeps to the second plan,
// not to the first.

#include "jaculus/evaluation/replan.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::evaluation {
namespace {

transcription::Problem tailless() {
  return transcription::read_problem(source_folder() / "problems" /
                                     "leap_tailless_as_published.yaml");
}

effects::EffectValue effect(const std::string& text, const transcription::Problem& problem) {
  return effects::read_effect(text, model::read_robot(problem.robot_folder).planar, "test");
}

TEST(Replan, ThePlanThatKnowsThePayloadIsKept) {
  const transcription::Problem problem = tailless();
  const std::vector<effects::EffectValue> payload = {
      effect("payload:mass=1,x=0.05,z=0.05", problem)};
  const Replan result = replan(problem, payload, replay_on_plant(problem.robot_folder, payload));
  ASSERT_TRUE(result.before.converged) << result.before.status;
  ASSERT_TRUE(result.after.converged) << result.after.status;
  EXPECT_TRUE(result.planner_knows);
  EXPECT_LT(result.after.planned_acceleration, result.before.planned_acceleration);
  EXPECT_GT(result.before.shortfall(), 0.2) << replan_text(result);
  RecordProperty("figures", replan_text(result));
  EXPECT_LT(std::abs(result.after.shortfall()), 0.3 * result.before.shortfall())
      << replan_text(result);
  EXPECT_EQ(nlohmann::json::parse(replan_json(result)).at("planner_knows"), true);
  EXPECT_NE(replan_text(result).find("effect known"), std::string::npos);
}

TEST(Replan, AnEffectThatPlanningCannotHaveIsSaidToBeSo) {
  const transcription::Problem problem = tailless();
  const std::vector<effects::EffectValue> delay = {effect("actuation_delay:delay=0.004", problem)};
  int replays = 0;
  const Replan result = replan(problem, delay, [&](const trajectory::Table&) {
    ++replays;
    return 1.0;
  });
  EXPECT_FALSE(result.planner_knows);
  EXPECT_EQ(replays, 1);
  EXPECT_EQ(result.before.realised_speed, result.after.realised_speed);
  EXPECT_NE(replan_text(result).find("planning can't have this effect"), std::string::npos);
}

TEST(Replan, OnTheTestbedTheSameHolds) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  const transcription::Problem problem = tailless();
  const std::vector<effects::EffectValue> payload = {
      effect("payload:mass=1,x=0.05,z=0.05", problem)};
  testbed::Changes changes;
  changes.payload = 1.0;
  changes.payload_place = {0.05, 0.05};
  const Replan result = replan(problem, payload, replay_on_testbed(problem.robot_folder, changes));
  ASSERT_TRUE(result.before.converged && result.after.converged);
  EXPECT_GT(result.before.shortfall(), 0.2) << replan_text(result);
  RecordProperty("figures", replan_text(result));
  EXPECT_LT(std::abs(result.after.shortfall()), 0.3 * result.before.shortfall())
      << replan_text(result);
}

}  // namespace
}  // namespace jaculus::evaluation
