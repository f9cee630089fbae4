#include "jaculus/studies/compare.h"

#include <gtest/gtest.h>

#include <cmath>

namespace jaculus::studies {
namespace {

std::vector<ComparedPlan> leaps() {
  return {{"tailless", TailKind::none, "0", true, 6.0, 5.5, 0.22},
          {"inactive", TailKind::held, "15", true, 5.0, 4.8, 0.25},
          {"inertial", TailKind::inertial, "0", true, 6.5, 6.0, 0.20},
          {"tail", TailKind::drag, "0", true, 6.6, 6.05, 0.198}};
}

TEST(Compare, GainsAreOverTheTaillessAndTheHeld) {
  const auto all = gains(leaps());
  EXPECT_TRUE(all[0].over_first.over.empty());
  EXPECT_NEAR(all[3].over_first.base, 0.1, 1e-12);
  EXPECT_NEAR(all[3].over_first.com, 0.1, 1e-12);
  EXPECT_NEAR(all[3].over_first.time, 0.1, 1e-12);
  EXPECT_FALSE(all[3].over_first.unlike);
  EXPECT_NEAR(all[3].over_inactive.base, 0.32, 1e-12);
  EXPECT_TRUE(all[3].over_inactive.unlike);
}

TEST(Compare, LikeIsPreferredToFirst) {
  auto plans = leaps();
  plans.push_back({"inactive_0", TailKind::held, "0", true, 5.5, 5.0, 0.24});
  const auto all = gains(plans);
  EXPECT_EQ(all[3].over_inactive.over, "inactive_0");
  EXPECT_FALSE(all[3].over_inactive.unlike);
}

TEST(Compare, DragIsWorthWhatItAddsToInertia) {
  const auto worth = drag_worth(leaps());
  ASSERT_EQ(worth.size(), 2u);
  EXPECT_EQ(worth[0].over, "tailless");
  EXPECT_NEAR(worth[0].base, 0.6 / 0.5 - 1.0, 1e-12);
  EXPECT_FALSE(worth[0].unlike);
  EXPECT_NEAR(worth[1].base, 1.6 / 1.5 - 1.0, 1e-12);
  EXPECT_TRUE(worth[1].unlike);
}

TEST(Compare, NothingIsGainedOverAPlanThatDidNotConverge) {
  auto plans = leaps();
  plans[0].converged = false;
  EXPECT_TRUE(std::isnan(gains(plans)[3].over_first.base));
  EXPECT_TRUE(std::isnan(drag_worth(plans)[0].base));
  // Drag can't be related to a gain that isn't there.
  plans = leaps();
  plans[2].base_acceleration = 5.9;
  EXPECT_TRUE(std::isnan(drag_worth(plans)[0].base));
}

TEST(Compare, ARatioToNextToNothingGivesWayToTheChangeItself) {
  auto plans = leaps();
  plans[2].base_acceleration = 6.08;  // inertia gains 0.08, drag as well 0.6 m/s^2: +650 %
  const DragWorth over_tailless = drag_worth(plans)[0];
  EXPECT_TRUE(std::isnan(over_tailless.base));
  EXPECT_NEAR(over_tailless.base_change, 0.52, 1e-12);
  EXPECT_NEAR(over_tailless.com, 0.55 / 0.5 - 1.0, 1e-12);  // of the centre of mass it is as it was

  plans = leaps();
  plans[0].base_acceleration = 0.01;  // it hops on the spot
  const Gain gained = gains(plans)[3].over_first;
  EXPECT_TRUE(std::isnan(gained.base));
  EXPECT_NEAR(gained.base_change, 6.59, 1e-12);
  EXPECT_NEAR(gained.time, 0.1, 1e-12);
}

TEST(Compare, WithoutATaillessPlanTheFirstCounts) {
  auto plans = leaps();
  plans.erase(plans.begin());
  EXPECT_EQ(gains(plans)[2].over_first.over, "inactive");
}

TEST(Compare, KindFollowsFromDragAndLocks) {
  model::PlanarModel model;
  model.bodies.resize(2);
  model.bodies[1].joint = "tail";
  transcription::Problem problem;
  EXPECT_EQ(tail_kind(problem, model), TailKind::none);
  model::PlanarDrag drag;
  drag.body = 1;
  model.drags = {drag};
  EXPECT_EQ(tail_kind(problem, model), TailKind::inertial);
  model.drags[0].coefficient = 2.0;
  EXPECT_EQ(tail_kind(problem, model), TailKind::drag);
  model.drags[0].kind = model::DragKind::none;
  EXPECT_EQ(tail_kind(problem, model), TailKind::inertial);
  problem.locks = {{"tail", -1.5}};
  EXPECT_EQ(tail_kind(problem, model), TailKind::held);
}

}  // namespace
}  // namespace jaculus::studies
