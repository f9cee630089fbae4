// Effects that lean one way on both engines: torque beside the motor's, friction by direction, a
// base that is held aslant. The same number must make the same motion, to half the noise floor; and
// blinded cases don't draw them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "jaculus/simulation/experiment.h"
#include "support/shared_data.h"
#include "testbed/both_engines.h"
#include "testbed/case_draws.h"

namespace jaculus::testbed {
namespace {

using test::kModels;

const std::vector<std::string> kNames = {"tail_torque_offset",        "leg_torque_offset",
                                         "joint_torque_offset",       "base_tilt",
                                         "tail_directional_friction", "leg_directional_friction",
                                         "joint_directional_friction"};

constexpr double kSticks = 1e-3;  ///< [rad/s]

/// Angles of the motors' joints, motors x samples [rad], and when [s].
struct Angles {
  Vector time;
  Matrix values;
};

Angles on_bench(const trajectory::Dataset& asked, const Changes& changes) {
  TrialSpec spec;
  spec.exact = true;
  spec.trials = 1;
  spec.after = 0.0;
  const trajectory::Dataset run = run_trials(asked, changes, spec);
  const trajectory::Stream& joints = *run.trials.front().stream(trajectory::kJointStream);
  const RobotFiles files = read_robot_files(model::find_robot(asked.robot, kModels));
  Angles out{joints.time, Matrix(std::ssize(files.planar_motors), joints.time.size())};
  for (int m = 0; m < count_of(files.planar_motors); ++m)
    out.values.row(m) = joints.values.row(joints.channel(files.planar_motors[m]));
  return out;
}

Matrix on_plant(const trajectory::Dataset& asked, const effects::Effect& effect,
                const Vector& theta, const Vector& time) {
  const model::PlanarModel model = simulation::dataset_robot(asked).planar;
  simulation::Plant plant = simulation::dataset_plant(asked, model);
  effect.apply(theta, plant);
  // MuJoCo's dry friction sticks; the plant's is smooth over a rate that is a choice of the model.
  for (simulation::JointFriction& friction : plant.friction) friction.smoothing_rate = kSticks;
  const simulation::Controller controller = simulation::stated_controller(asked, model, {});
  simulation::SimulationOptions options;
  options.duration = time[time.size() - 1];
  options.sample_times = time;
  options.relative_tolerance = 1e-8;
  options.absolute_tolerance = 1e-10;
  const simulation::Simulation run = simulation::simulate(
      plant, controller, simulation::reference_start(plant, controller.reference), options);
  EXPECT_EQ(run.status, simulation::SimulationStatus::done) << run.message;
  Matrix angles(std::ssize(model.motors), time.size());
  for (int m = 0; m < count_of(model.motors); ++m)
    angles.row(m) = run.q.row(model.coordinate_index(model.motors[m].joint));
  return angles;
}

struct Lean {
  const char* robot;
  const char* effect;
  std::vector<double> values;
};

class Leaning : public ::testing::TestWithParam<Lean> {};

TEST_P(Leaning, SwingsAlikeOnBothEngines) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const Lean& lean = GetParam();
  const trajectory::Dataset asked = swing(kModels / lean.robot, SwingInput::torque);
  Changes changes;
  const auto known = bench_effects(kModels / lean.robot);
  const BenchEffect* bench_effect = find_bench_effect(known, lean.effect);
  ASSERT_NE(bench_effect, nullptr);
  bench_effect->apply(lean.values, changes);

  const Angles still = on_bench(asked, {}), bench = on_bench(asked, changes);
  const effects::Effect* effect = effects::find_effect(lean.effect);
  ASSERT_NE(effect, nullptr);
  const Vector theta = Eigen::Map<const Vector>(lean.values.data(), std::ssize(lean.values));
  const Matrix plant = on_plant(asked, *effect, theta, bench.time);
  const double gap = (bench.values - still.values).cwiseAbs().maxCoeff();
  EXPECT_GT(gap, 10.0 * test::kHalfAngle) << "the effect is too small to tell anything";
  EXPECT_LT((bench.values - plant).cwiseAbs().maxCoeff(), test::kHalfAngle) << "gap " << gap;
}

INSTANTIATE_TEST_SUITE_P(
    Swings, Leaning,
    ::testing::Values(Lean{"pendulum", "joint_torque_offset", {0.2}},
                      Lean{"double_pendulum", "joint_torque_offset", {-0.1}},
                      Lean{"arm", "joint_torque_offset", {0.03}},
                      Lean{"pendulum", "base_tilt", {0.05}},
                      Lean{"double_pendulum", "base_tilt", {-0.1}},
                      Lean{"arm", "base_tilt", {0.05}},
                      Lean{"pendulum", "joint_directional_friction", {0.1, 0.6}},
                      Lean{"double_pendulum", "joint_directional_friction", {0.05, -0.5}}),
    [](const auto& info) { return std::string(info.param.robot) + "_" + info.param.effect; });

TEST(Leaning, LeapsAlikeOnBothEngines) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  JACULUS_REQUIRE_SHARED_DATA(data);
  const trajectory::Dataset asked =
      leap(kModels / "minitaur_tail", data / "plans" / "aerotail_V7_nodes82.csv",
           trajectory::Quantity::duty);
  for (const auto& [name, value] :
       std::vector<std::pair<const char*, double>>{{"leg_torque_offset", 0.1},
                                                   {"tail_torque_offset", -2.0},
                                                   {"leg_directional_friction", 0.1},
                                                   {"tail_directional_friction", 4.0}}) {
    SCOPED_TRACE(name);
    test::expect_the_same_gap(asked, name, value, 0.05);
  }
}

TEST(Leaning, IsPlayedByNameAndLeavesTheDrawsOfBatchesAlone) {
  int seen = 0;
  for (const char* robot : {"minitaur_tail", "double_pendulum"}) {
    const auto known = bench_effects(kModels / robot);
    for (const BenchEffect& effect : known) {
      const std::string name = name_without_joint(effect.name);
      const bool leans = std::find(kNames.begin(), kNames.end(), name) != kNames.end();
      EXPECT_EQ(effect.by_name_only, leans) << effect.name;
      seen += leans && effect.joint.empty() ? 1 : 0;
    }
  }
  EXPECT_EQ(seen, count_of(kNames) + 1) << "both robots have a base that can be held";

  const Stage stage = make_stage("swing", swing(kModels / "double_pendulum", SwingInput::torque));
  const Pool pool = pool_of({stage}, {});
  const std::vector<std::string> signatures = signature_effects(stage);
  EXPECT_NE(acting_effect(stage, "joint_torque_offset"), nullptr);
  for (const std::string& name : kNames) {
    for (const auto& [drawn, component] : pool.components)
      EXPECT_NE(name_without_joint(drawn), name);
    EXPECT_EQ(std::count(signatures.begin(), signatures.end(), name), 0) << name;
  }
}

}  // namespace
}  // namespace jaculus::testbed
