// Baselines on a pendulum whose friction nobody told: each must name it.

#include "evaluation/baselines.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/baseline_problem.h"
#include "evaluation/residual_torque.h"
#include "sample_trials.h"
#include "support/temporary_folder.h"

namespace jaculus::evaluation {
namespace {

TEST(Baselines, EachFindsAPlantedFriction) {
  const test::TemporaryFolder folder;
  const auto predictions =
      baseline_answers({trials_with(folder, "joint_coulomb_friction:torque=0.4")});
  ASSERT_EQ(predictions.size(), baseline_names().size());
  for (int i = 0; i < count_of(predictions); ++i) {
    const Prediction& prediction = predictions[i];
    EXPECT_EQ(prediction.verdict, diagnosis::Verdict::effect) << baseline_names()[i];
    ASSERT_EQ(prediction.effects.size(), 1u) << baseline_names()[i];
    EXPECT_GT(prediction.ranking.size(), 5u);
    // Friction, if not always its kind: the more flexible one fits as well or better.
    EXPECT_TRUE(prediction.effects[0].name.ends_with("_friction"))
        << baseline_names()[i] << ": " << prediction.effects[0].name;
  }
  EXPECT_EQ(predictions.back().effects[0].name, "joint_coulomb_friction");
}

TEST(Baselines, TheOneWithALikelihoodStatesProbabilities) {
  const test::TemporaryFolder folder;
  const auto predictions =
      baseline_answers({trials_with(folder, "joint_coulomb_friction:torque=0.4")});
  for (int i = 0; i < count_of(predictions); ++i) {
    double sum = 0.0;
    for (const auto& [name, p] : predictions[i].ranking) sum += p;
    EXPECT_NEAR(sum, states_probability(baseline_names()[i]) ? 1.0 : 0.0, 1e-9);
  }
  EXPECT_LT(predictions[0].ranking.at("none"), 1e-3);
}

TEST(Baselines, SayNoneWhereThereIsNothing) {
  const test::TemporaryFolder folder;
  const auto predictions = baseline_answers({trials_with(folder, "")});
  for (int i = 0; i < count_of(predictions); ++i)
    EXPECT_EQ(predictions[i].verdict, diagnosis::Verdict::none) << baseline_names()[i];
}

TEST(ResidualTorque, IsTheFrictionThatWasPlanted) {
  const test::TemporaryFolder folder;
  const auto ready = baseline_problem(
      {trajectory::read_dataset(trials_with(folder, "joint_coulomb_friction:torque=0.4"))});
  ASSERT_TRUE(ready);
  const std::vector<JointTorque> joints = residual_torques(*ready);
  ASSERT_EQ(joints.size(), 1u);
  ASSERT_GT(joints[0].torque.size(), 60);
  // Where it swings fast the sign is plain, and the model lacks 0.4 N m against it.
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index i = 0; i < joints[0].torque.size(); ++i) {
    const double sign = joints[0].library(i, static_cast<int>(TorqueTerm::sign));
    if (std::abs(sign) < 0.99) continue;
    sum += joints[0].torque[i] * sign;
    ++count;
  }
  ASSERT_GT(count, 30);
  EXPECT_NEAR(sum / count, -0.4, 0.06);
}

TEST(ResidualTorque, TermsStandForEffectsOfTheirMeaning) {
  const test::TemporaryFolder folder;
  const auto ready = baseline_problem({trajectory::read_dataset(trials_with(folder, ""))});
  ASSERT_TRUE(ready);
  const auto effect = [&](TorqueTerm term) {
    return effect_of_term(ready->problem->hypotheses,
                          ready->problem->observations.datasets.front().model, "pendulum", term);
  };
  EXPECT_EQ(effect(TorqueTerm::sign), "joint_coulomb_friction");
  EXPECT_EQ(effect(TorqueTerm::speed), "joint_viscous_friction");
  EXPECT_EQ(effect(TorqueTerm::acceleration), "joint_rotor_inertia");
  EXPECT_EQ(effect(TorqueTerm::sine), "link_mass");
  EXPECT_EQ(effect(TorqueTerm::cosine), "link_mass");
  EXPECT_EQ(effect(TorqueTerm::constant), "");
  EXPECT_EQ(effect(TorqueTerm::speed_cubed), "");
}

TEST(Baselines, WithoutJointsTheTorqueIsInsufficient) {
  const test::TemporaryFolder folder;
  auto ready = baseline_problem({trajectory::read_dataset(trials_with(folder, ""))});
  ASSERT_TRUE(ready);
  auto problem = std::make_shared<diagnosis::Problem>(*ready->problem);
  problem->observations = without_channels(problem->observations, {{0, 0}});  // the angle
  ready->problem = problem;
  ready->noise = diagnosis::estimate_noise(*problem, ready->base.p);
  EXPECT_TRUE(residual_torques(*ready).empty());
}

}  // namespace
}  // namespace jaculus::evaluation
