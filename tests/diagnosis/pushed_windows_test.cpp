// Effects in a log of a robot that was pushed now and then.

#include "diagnosis/pushed_windows.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "diagnosis/effects_by_name.h"
#include "diagnosis/logged_trials.h"
#include "jaculus/diagnosis/diagnose.h"
#include "support/temporary_folder.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kDryFriction = 0.15, kPushPeak = 2.0, kPushLength = 0.4;  // [N m, N m, s]

std::string push_file(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "push.yaml";
  std::ofstream(file)
      << "format: jaculus-effect/1\nname: once\ncaption: pushes once\nat: {joint: pendulum}\n"
         "parameters:\n"
         "  peak: {unit: N m, nominal: 0, bounds: [-5, 5], scale: 1}\n"
         "  start: {unit: s, nominal: 1, bounds: [0, 3], scale: 1}\n"
         "  length: {unit: s, nominal: 0.3, bounds: [0.1, 1], scale: 0.1}\n"
         "torque: \"peak*sin(pi*max(0, min(1, (t - start)/length)))\"\n";
  return file.string();
}

/// Six trials with dry friction; at `starts` the first ones are pushed, one after the other to and
/// fro.
trajectory::Dataset pushed(const std::vector<double>& starts) {
  const test::TemporaryFolder folder;
  const std::string friction = fmt::format("joint_coulomb_friction:torque={}", kDryFriction);
  trajectory::Dataset dataset = test::logged("pendulum_trials.yaml", {}, {friction}, 6, 3);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const std::string push =
        fmt::format("once:peak={},start={},length={}", k % 2 == 0 ? kPushPeak : -kPushPeak,
                    starts[k], kPushLength);
    const trajectory::Dataset other =
        test::logged("pendulum_trials.yaml", {push_file(folder.path())}, {friction, push}, 6, 3);
    dataset.trials[k].streams = other.trials[k].streams;
  }
  return dataset;
}

TEST(PushedWindows, LieBesideWhatActedOnce) {
  DiagnoseOptions options = test::among({"joint_coulomb_friction"});
  const BuiltProblem built = build_problem({pushed({0.6, 1.4})}, options);
  ModelFit none;
  none.fit.p = built.problem->hypotheses.nominal();
  const std::optional<BesidePushes> beside = beside_pushes(*built.problem, none, options);
  ASSERT_TRUE(beside.has_value());
  ASSERT_EQ(beside->notes.size(), 2U) << beside->notes.front();
  EXPECT_EQ(beside->notes[0].find("trial_01: something seems to act once at pendulum"), 0U);

  const ObservedDataset& before = built.problem->observations.datasets.front();
  const ObservedDataset& after = beside->observations.datasets.front();
  EXPECT_EQ(after.trials, 6);
  EXPECT_LT(after.segments.size(), before.segments.size());
  for (const Segment& window : after.segments) {
    const double from = window.trial == 0 ? 0.6 : window.trial == 1 ? 1.4 : kInfinity;
    EXPECT_FALSE(window.start < from + kPushLength && from < window.end()) << window.start;
  }
  const auto in_trial = [](const ObservedDataset& observed, int trial) {
    return std::count_if(observed.segments.begin(), observed.segments.end(),
                         [&](const Segment& window) { return window.trial == trial; });
  };
  EXPECT_EQ(in_trial(after, 5), in_trial(before, 5));
}

TEST(PushedWindows, StayInATrialThatHasNoRoomBesideThem) {
  const BuiltProblem built = build_problem({pushed({})}, test::among({"joint_coulomb_friction"}));
  const Observations& before = built.problem->observations;
  const Settings& settings = built.problem->settings;
  const ObservedDataset& all = before.datasets.front();
  const ObservedDataset same =
      with_windows_beside(before, {{0, 2, 0.0, 3.0}}, settings).datasets.front();
  ASSERT_EQ(same.segments.size(), all.segments.size());
  for (std::size_t k = 0; k < all.segments.size(); ++k)
    EXPECT_EQ(same.segments[k].start, all.segments[k].start);
  // Of the last second nothing is left, and the windows before it stay where they are.
  const ObservedDataset shorter =
      with_windows_beside(before, {{0, 2, 2.0, 3.0}}, settings).datasets.front();
  EXPECT_EQ(shorter.segments.size(), all.segments.size() - 2);
}

TEST(PushedWindows, AreAllWhereNothingPushed) {
  DiagnoseOptions options = test::among({"joint_coulomb_friction"});
  const BuiltProblem built = build_problem({pushed({})}, options);
  ModelFit none;
  none.fit.p = built.problem->hypotheses.nominal();
  EXPECT_FALSE(beside_pushes(*built.problem, none, options).has_value());
}

// With the pushed windows among the others nothing is named.
TEST(PushedWindows, LeaveAnEffectItsValue) {
  const DiagnoseOptions options =
      test::among({"joint_coulomb_friction", "joint_viscous_friction", "joint_rotor_inertia"});
  const Diagnosis found = diagnose({pushed({0.6, 1.4, 0.9, 1.8, 0.3, 2.2})}, options);
  ASSERT_EQ(found.effects.size(), 1U) << to_text(found.verdict);
  EXPECT_EQ(found.effects.front().name, "joint_coulomb_friction");
  const FoundParameter& torque = found.effects.front().parameters.front();
  EXPECT_NEAR(torque.value, kDryFriction, 0.1 * kDryFriction);
  EXPECT_TRUE(torque.ci95.contains(kDryFriction));
}

}  // namespace
}  // namespace jaculus::diagnosis
