// Everything that the testbed's robots can have beside the catalogue's whole groups of joints:
// outside kinds, pushes and effects at one joint. Each is nothing at its value without effect, and
// something at a good third of its largest.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <set>

#include "jaculus/effects/effect.h"
#include "jaculus/testbed/effects.h"
#include "testbed/both_engines.h"
#include "testbed/sizes.h"

namespace jaculus::testbed {
namespace {

using trajectory::ExperimentKind;

/// Of the largest strength; no simple fraction, since steps of a command may divide a command.
constexpr double kShare = 0.37;

/// Two waves of torque on every motor of a robot on a fixed base, new values every 5 ms.
trajectory::Dataset rocked(const std::string& robot) {
  const RobotFiles files = read_robot_files(test::kModels / robot);
  constexpr int kSamples = 201;
  const double share = files.planar_motors.size() == 1 ? 0.5 : 0.2;

  trajectory::Dataset asked;
  asked.experiment = ExperimentKind::pendulum;
  asked.robot = robot;
  asked.controller.kind = trajectory::ControllerKind::torque;
  asked.controller.quantity = trajectory::Quantity::torque;
  trajectory::InputScript script;
  script.quantity = trajectory::Quantity::torque;
  script.joints = files.planar_motors;
  script.time = Vector::LinSpaced(kSamples, 0.0, 1.0);
  script.values.resize(count_of(script.joints), kSamples);
  for (int i = 0; i < count_of(script.joints); ++i) {
    const JointSize size = size_of(files, files.drives[files.sides_of(script.joints[i]).front()]);
    const Vector phase = (5.0 + i) * script.time;
    script.values.row(i) =
        share * size.torque * (phase.array().sin() + 0.2 * (7.0 * phase.array()).sin());
    asked.initial[script.joints[i]] = 0.0;
  }
  asked.script = script;
  return asked;
}

trajectory::Trial trial_of(const trajectory::Dataset& asked, const Changes& changes) {
  TrialSpec spec;
  spec.exact = true;
  spec.trials = 1;
  spec.after = 0.0;
  return run_trials(asked, changes, spec).trials.front();
}

/// Largest difference of any channel [SI].
double difference(const trajectory::Trial& a, const trajectory::Trial& b) {
  double most = 0.0;
  for (const trajectory::Stream& stream : a.streams) {
    const Matrix& other = b.stream(stream.name)->values;
    most = std::max(most, (stream.values - other).cwiseAbs().maxCoeff());
  }
  return most;
}

bool acts_on(const BenchEffect& effect, ExperimentKind kind) {
  return std::find(effect.experiments.begin(), effect.experiments.end(), kind) !=
         effect.experiments.end();
}

/// Those that act in the experiment; not those of `seen_in`, another one.
void expect_each_acts(const trajectory::Dataset& asked, const std::filesystem::path& robot,
                      std::optional<ExperimentKind> seen_in = std::nullopt) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const trajectory::Trial plain = trial_of(asked, {});
  int seen = 0;

  for (const BenchEffect& effect : bench_effects(robot)) {
    if (!acts_on(effect, asked.experiment) || (!effect.outside && effect.joint.empty())) continue;
    if (seen_in && acts_on(effect, *seen_in)) continue;
    std::vector<double> values = usual_values(effect);
    Changes none, some;
    effect.apply(values, none);
    EXPECT_EQ(difference(plain, trial_of(asked, none)), 0.0) << effect.name;

    const BenchParameter& strength = effect.parameters.front();
    values[0] += kShare * (strength.upper - strength.usual);
    effect.apply(values, some);
    const double by = difference(plain, trial_of(asked, some));
    EXPECT_GT(by, 1e-4) << effect.name;
    EXPECT_LT(by, 1e3) << effect.name << " is not stable";
    ++seen;
  }
  EXPECT_GE(seen, seen_in ? 1 : 10);
}

class KindsOnFixedRobots : public ::testing::TestWithParam<const char*> {};

TEST_P(KindsOnFixedRobots, AreNothingWithoutStrengthAndSomethingWithIt) {
  expect_each_acts(rocked(GetParam()), test::kModels / GetParam());
}

INSTANTIATE_TEST_SUITE_P(Models, KindsOnFixedRobots,
                         ::testing::Values("pendulum", "double_pendulum", "arm", "slider"),
                         [](const auto& info) { return std::string(info.param); });

TEST(KindsOnTheMinitaur, AreNothingWithoutStrengthAndSomethingWithItOnTheBench) {
  const auto robot = test::kModels / "minitaur_tail";
  expect_each_acts(tail_bench(robot), robot);
}

TEST(KindsOnTheMinitaur, AreNothingWithoutStrengthAndSomethingWithItInTheAir) {
  const auto robot = test::kModels / "minitaur_tail";
  expect_each_acts(self_righting(robot), robot, ExperimentKind::tail_bench);
  expect_each_acts(
      leap(robot, source_folder() / "problems" / "leap_tail_plan.csv", trajectory::Quantity::duty),
      robot, ExperimentKind::tail_bench);
}

/// Outside kinds of a robot in an experiment, pushes aside.
std::set<std::string> kinds_of(const std::string& robot, ExperimentKind kind) {
  std::set<std::string> names;
  for (const BenchEffect& effect : bench_effects(test::kModels / robot))
    if (effect.outside && !effect.event && acts_on(effect, kind)) names.insert(effect.name);
  return names;
}

TEST(OutsideKinds, AreManyAndEveryExperimentHasTen) {
  std::set<std::string> all = kinds_of("minitaur_tail", ExperimentKind::leap);
  for (const std::string robot : {"pendulum", "double_pendulum", "arm", "slider"}) {
    const std::set<std::string> names = kinds_of(robot, ExperimentKind::pendulum);
    EXPECT_GE(names.size(), 10U) << robot;
    all.insert(names.begin(), names.end());
  }
  for (const ExperimentKind kind : {ExperimentKind::tail_bench, ExperimentKind::self_righting})
    EXPECT_GE(kinds_of("minitaur_tail", kind).size(), 10U) << name_of(kind);
  EXPECT_GE(all.size(), 24U);
}

TEST(OutsideKinds, HaveNoNameOfTheCatalogue) {
  for (const std::string robot : {"minitaur_tail", "arm"})
    for (const BenchEffect& effect : bench_effects(test::kModels / robot))
      EXPECT_EQ(effects::find_effect(name_without_joint(effect.name)) == nullptr, effect.outside)
          << effect.name;
}

TEST(OneJoint, ChangesThatJointAlone) {
  const RobotFiles files = read_robot_files(test::kModels / "double_pendulum");
  const auto effects = bench_effects(files);
  for (const BenchEffect& effect : effects) {
    if (effect.joint.empty()) continue;
    EXPECT_TRUE(effect.name.ends_with("@" + effect.joint)) << effect.name;
    EXPECT_FALSE(files.sides_of(effect.joint).empty()) << effect.name;
  }

  Changes changes;
  apply_effect("joint_viscous_friction@elbow:coefficient=0.05", effects, changes);
  apply_effect("joint_offset@elbow:offset=-0.05", effects, changes);
  EXPECT_EQ(changes.joint_friction.size(), 1U);
  EXPECT_EQ(changes.joint_friction["elbow"].viscous, 0.05);
  EXPECT_EQ(changes.joint_offset, (std::map<std::string, double>{{"elbow", -0.05}}));
  EXPECT_EQ(find_bench_effect(bench_effects(test::kModels / "pendulum"), "joint_offset@swing"),
            nullptr)
      << "its only joint needs no such name";
}

}  // namespace
}  // namespace jaculus::testbed
