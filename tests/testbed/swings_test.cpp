// Swings of robots on a fixed base, a quadruped's leap, drop and bench: what they are, that both
// engines agree on every motion over its whole length, and that none is sensitive.

#include "testbed/swings.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "jaculus/core/installation.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/testbed/playback.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"
#include "testbed/both_engines.h"
#include "testbed/commands.h"
#include "testbed/draws.h"
#include "testbed/mjcf.h"

namespace jaculus::testbed {
namespace {

using test::holds;
using test::input_error_of;
using test::kModels;
using trajectory::ControllerKind;

/// Planar motors x samples, and when they were taken.
struct JointMotion {
  Vector time;
  Matrix angles, torques;  ///< [rad], [N m]
};

TrialSpec exact_joints() {
  TrialSpec spec;
  spec.exact = true;
  spec.trials = 1;
  spec.after = 0.0;
  spec.sensors.torque = true;
  return spec;
}

JointMotion joints_on_testbed(const trajectory::Dataset& asked, const Changes& changes = {}) {
  const RobotFiles files = read_robot_files(model::find_robot(asked.robot, kModels));
  const trajectory::Dataset run = run_trials(asked, changes, exact_joints());
  const trajectory::Stream& joints = *run.trials.front().stream(trajectory::kJointStream);
  const auto motors = std::ssize(files.planar_motors);
  JointMotion out{joints.time, Matrix(motors, joints.time.size()),
                  Matrix(motors, joints.time.size())};
  for (int m = 0; m < count_of(files.planar_motors); ++m) {
    const std::string& name = files.planar_motors[m];
    out.angles.row(m) = joints.values.row(joints.channel(name));
    out.torques.row(m) = joints.values.row(joints.channel(name + "_torque"));
  }
  return out;
}

/// Angles of the motors' joints on the plant at some times; gains amid their ranges. `change`: of
/// the plant, where it isn't nominal.
Matrix joints_on_plant(trajectory::Dataset asked, const Vector& time,
                       const std::function<void(simulation::Plant&)>& change = {}) {
  if (asked.controller.kind == ControllerKind::measured)
    asked.controller.kind = ControllerKind::torque;
  for (auto* gains : {&asked.controller.kp, &asked.controller.kd})
    for (auto& [joint, gain] : *gains)
      gain.range.lower = gain.range.upper = std::sqrt(gain.range.lower * gain.range.upper);

  const model::PlanarModel model = simulation::dataset_robot(asked).planar;
  simulation::Plant plant = simulation::dataset_plant(asked, model);
  if (change) change(plant);
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

struct Ride {
  const char* robot;
  SwingInput input;
};

class Swings : public ::testing::TestWithParam<Ride> {
 protected:
  void SetUp() override {
    if (!available()) GTEST_SKIP() << "built without MuJoCo";
    asked_ = swing(kModels / GetParam().robot, GetParam().input);
  }
  trajectory::Dataset asked_;
};

TEST_P(Swings, AreTheSameOnBothEngines) {
  const JointMotion bench = joints_on_testbed(asked_);
  const Matrix plant = joints_on_plant(asked_, bench.time);
  ASSERT_EQ(plant.rows(), bench.angles.rows());
  for (Eigen::Index i = 0; i < plant.rows(); ++i) {
    const double swing = bench.angles.row(i).maxCoeff() - bench.angles.row(i).minCoeff();
    EXPECT_GT(swing, 4.0 * test::kDegree) << "joint " << i << " hardly moves";
    EXPECT_LT((bench.angles.row(i) - plant.row(i)).cwiseAbs().maxCoeff(), test::kHalfAngle)
        << "joint " << i << ", which swings by " << swing << " rad";
  }
}

/// A motion that grows small differences shows them between step sizes.
TEST_P(Swings, EndAtTheSameAnglesWithTwiceAsManySteps) {
  const RobotFiles files = read_robot_files(kModels / GetParam().robot);
  const PlanCommands plan = dataset_commands(asked_, files, TrialSpec{});
  PlayOptions options;
  options.floor = false;
  options.base_fixed = true;
  options.start = plan.start;
  options.duration = plan.duration;
  Numerics fine;
  fine.step *= 0.5;
  const Recording one = play(files, {}, plan.commands, options, Numerics{});
  const Recording other = play(files, {}, plan.commands, options, fine);
  const Vector apart = one.position.rightCols<1>() - other.position.rightCols<1>();
  EXPECT_LT(apart.cwiseAbs().maxCoeff(), 0.5 * test::kDegree);
}

/// Another start by 4 mrad, as trials scatter it, may not end more than ten times as far away.
TEST_P(Swings, KeepStartsThatAreNearNearEachOther) {
  TrialSpec spec = exact_joints(), moved = spec;
  const RobotFiles files = read_robot_files(kModels / GetParam().robot);
  for (const std::string& joint : files.planar_motors) moved.start_offset[joint] = 4e-3;
  const trajectory::Dataset a = run_trials(asked_, {}, spec), b = run_trials(asked_, {}, moved);
  for (const std::string& joint : files.planar_motors) {
    const trajectory::Stream &was = a.trials[0].streams[0], &is = b.trials[0].streams[0];
    const int row = was.channel(joint);
    EXPECT_LT((is.values.row(row) - was.values.row(row)).cwiseAbs().maxCoeff(), 0.04) << joint;
    const Bounds range = files.joint_of(joint).range;
    EXPECT_GT(was.values.row(row).minCoeff(), range.lower) << joint;
    EXPECT_LT(was.values.row(row).maxCoeff(), range.upper) << joint;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Robots, Swings,
    ::testing::Values(Ride{"pendulum", SwingInput::torque},
                      Ride{"pendulum", SwingInput::logged_torque},
                      Ride{"pendulum", SwingInput::unknown_gains},
                      Ride{"ak80_pendulum", SwingInput::logged_torque},
                      Ride{"double_pendulum", SwingInput::torque},
                      Ride{"double_pendulum", SwingInput::logged_torque},
                      Ride{"double_pendulum", SwingInput::unknown_gains},
                      Ride{"double_pendulum", SwingInput::voltage}, Ride{"arm", SwingInput::torque},
                      Ride{"arm", SwingInput::logged_torque},
                      Ride{"arm", SwingInput::unknown_gains}, Ride{"arm", SwingInput::voltage}),
    [](const auto& info) {
      return std::string(info.param.robot) + "_" + swing_inputs().name(info.param.input);
    });

/// What is wrong at one joint moves the double pendulum alike on both engines: the same name and
/// number mean the same thing where joints are light, too.
TEST(Swing, IsMovedAlikeByEachEffectAtAJoint) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const trajectory::Dataset asked = swing(kModels / "double_pendulum", SwingInput::torque);
  const RobotFiles files = read_robot_files(kModels / "double_pendulum");
  const std::vector<BenchEffect> bench = bench_effects(files);
  const model::PlanarModel model = simulation::dataset_robot(asked).planar;
  const JointMotion still = joints_on_testbed(asked);
  const Matrix nominal = joints_on_plant(asked, still.time);

  struct Wrong {
    const char *name, *joint;
    double value;
  };
  for (const Wrong& wrong : {Wrong{"joint_backlash", "elbow", 0.014},
                             {"joint_backlash", "elbow", 0.05},
                             {"joint_backlash", "shoulder", 0.03},
                             {"joint_coulomb_friction", "elbow", 0.02},
                             {"joint_viscous_friction", "shoulder", 0.01},
                             {"joint_load_friction", "elbow", 0.1},
                             {"joint_torque_offset", "elbow", 0.02},
                             {"joint_rotor_inertia", "elbow", 3e-5},
                             {"torque_constant", "elbow", 0.9}}) {
    const std::string name = fmt::format("{}@{}", wrong.name, wrong.joint);
    Changes changes;
    const BenchEffect* effect = find_bench_effect(bench, name);
    ASSERT_NE(effect, nullptr) << name;
    std::vector<double> values{wrong.value};
    for (std::size_t k = 1; k < effect->parameters.size(); ++k)
      values.push_back(effect->parameters[k].usual);
    effect->apply(values, changes);

    const std::vector<effects::Effect> sized =
        effects::sized_for(*effects::find_effect(wrong.name), model, {});
    const auto own = std::find_if(sized.begin(), sized.end(),
                                  [&](const effects::Effect& e) { return e.name == name; });
    ASSERT_NE(own, sized.end()) << name;
    Vector theta = own->nominal();
    theta[0] = wrong.value;
    const Matrix there = joints_on_testbed(asked, changes).angles - still.angles;
    const Matrix here =
        joints_on_plant(asked, still.time, [&](simulation::Plant& p) { own->apply(theta, p); }) -
        nominal;
    EXPECT_GT(there.norm(), 1e-3) << name;
    EXPECT_LT((here - there).norm(), 0.12 * there.norm()) << name;
  }
}

TEST(Swing, LogsTheTorquesThatDroveItAndNotItsCommands) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const trajectory::Dataset asked = swing(kModels / "arm", SwingInput::logged_torque);
  const JointMotion bench = joints_on_testbed(asked);
  trajectory::Dataset driven = asked;
  driven.script->time = bench.time;
  driven.script->values = bench.torques;
  const Matrix plant = joints_on_plant(driven, bench.time);
  EXPECT_LT((bench.angles - plant).cwiseAbs().maxCoeff(), test::kHalfAngle);

  test::TemporaryFolder folder;
  trajectory::Dataset run = run_trials(asked, {}, exact_joints());
  EXPECT_FALSE(run.script.has_value());
  trajectory::write_dataset(run, folder / "swing");
  const trajectory::Dataset read = trajectory::read_dataset(folder / "swing");
  EXPECT_EQ(read.controller.kind, ControllerKind::measured);
  EXPECT_FALSE(read.script.has_value() || read.plan.has_value());
}

/// A driver works torque out of its current: magnets that are weaker don't show in its log.
TEST(Swing, ADriverLogsWhatItsCurrentWouldGive) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const trajectory::Dataset asked = swing(kModels / "double_pendulum", SwingInput::logged_torque);
  Changes weaker;
  weaker.torque_constant = 0.8;
  const auto torque_of = [&](const Changes& changes) {
    const trajectory::Dataset run = run_trials(asked, changes, exact_joints());
    const trajectory::Stream& joints = *run.trials[0].stream(trajectory::kJointStream);
    return Vector(joints.values.row(joints.channel("shoulder_torque")).transpose());
  };
  EXPECT_LT((torque_of(weaker) - torque_of({})).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Swing, PlaysGainsWithinTheStatedRange) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const trajectory::Dataset asked = swing(kModels / "arm", SwingInput::unknown_gains);
  const trajectory::StatedGain stated = asked.controller.kp.at("elbow");
  EXPECT_FALSE(stated.known());
  const RobotFiles files = read_robot_files(kModels / "arm");
  TrialSpec spec;
  spec.kp_place = 0.0;
  EXPECT_DOUBLE_EQ(dataset_commands(asked, files, spec).commands.kp.at("elbow"),
                   stated.range.lower);
  spec.kp_place = 1.0;
  EXPECT_DOUBLE_EQ(dataset_commands(asked, files, spec).commands.kp.at("elbow"),
                   stated.range.upper);

  trajectory::Dataset open = asked;
  open.controller.kp["elbow"].range = {0.0, kInfinity};
  EXPECT_TRUE(
      holds(input_error_of([&] { (void)dataset_commands(open, files, spec); }), "gain of 'elbow'"));
}

TEST(Swing, RefusesRobotsThatCannot) {
  EXPECT_TRUE(holds(input_error_of([] { (void)swing(kModels / "minitaur", SwingInput::torque); }),
                    "no robot for a swing"));
  EXPECT_TRUE(holds(input_error_of([] { (void)swing(kModels / "pendulum", SwingInput::voltage); }),
                    "no robot for a swing"));
  EXPECT_TRUE(holds(input_error_of([] { (void)leg_drop(kModels / "arm"); }), "a fixed base"));
  EXPECT_TRUE(holds(input_error_of([] { (void)leg_bench(kModels / "minitaur"); }), "pins"));
}

/// The load of the double pendulum, by hand: 0.62 kg at 0.17 m, 0.45 kg at 0.2 + 0.24 m.
TEST(Load, IsWhatHangsOnAJoint) {
  const RobotFiles files = read_robot_files(kModels / "double_pendulum");
  const Load shoulder = load_of(files, "shoulder");
  EXPECT_NEAR(shoulder.weight, 9.81 * (0.62 * 0.17 + 0.45 * 0.44), 1e-12);
  EXPECT_NEAR(shoulder.hold, 0.0, 1e-12);
  EXPECT_NEAR(shoulder.inertia,
              0.62 * 0.17 * 0.17 + 0.0029 + 0.45 * 0.44 * 0.44 + 0.0042 + 6.07e-5 * 36.0, 1e-12);
  // the arm's wrist: 0.4 kg at 0.06 m, 3 rad from straight up
  const Load wrist = load_of(read_robot_files(kModels / "arm"), "wrist");
  EXPECT_NEAR(std::abs(wrist.hold), 9.81 * 0.4 * 0.06 * std::sin(3.0), 1e-12);
}

TEST(Quadruped, LeapsByTorqueAndDutyAsOnThePlant) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const auto plan = source_folder() / "problems" / "leap_quadruped25_plan.csv";
  for (const auto quantity : {trajectory::Quantity::torque, trajectory::Quantity::duty}) {
    SCOPED_TRACE(name_of(quantity));
    test::expect_agreement(leap(kModels / "quadruped25", plan, quantity), 0.05);
  }
}

TEST(Quadruped, DropsAsOnThePlant) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  test::expect_agreement(leg_drop(kModels / "quadruped25"), 0.0);
}

TEST(Quadruped, SwingsItsLegsOnTheBenchAsOnThePlant) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const trajectory::Dataset asked = leg_bench(kModels / "quadruped25");
  const JointMotion bench = joints_on_testbed(asked);
  const Matrix plant = joints_on_plant(asked, bench.time);
  EXPECT_GT(bench.angles.row(0).maxCoeff() - bench.angles.row(0).minCoeff(), 4.0 * test::kDegree);
  EXPECT_LT((bench.angles - plant).cwiseAbs().maxCoeff(), test::kHalfAngle);
}

TEST(Stages, AreAllThatEveryRobotCanDo) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  std::vector<std::string> names;
  for (const Stage& stage :
       all_stages({source_folder() / "problems" / "leap_quadruped25_plan.csv"},
                  {kModels / "quadruped25", kModels / "pendulum", kModels / "arm"}))
    names.push_back(stage.name);
  EXPECT_EQ(names, (std::vector<std::string>{
                       "leap leap_quadruped25_plan.csv torque",
                       "leap leap_quadruped25_plan.csv duty", "self_righting quadruped25",
                       "tail_bench quadruped25", "pendulum pendulum", "pendulum torque pendulum",
                       "pendulum logged_torque pendulum", "pendulum unknown_gains pendulum",
                       "pendulum torque arm", "pendulum logged_torque arm",
                       "pendulum unknown_gains arm", "pendulum voltage arm"}));
}

TEST(Stages, WhatComesBeforeALogOfTorquesDoesNotActOnOne) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const Stage commanded =
      make_stage("torque", swing(kModels / "double_pendulum", SwingInput::torque));
  const Stage logged =
      make_stage("logged", swing(kModels / "double_pendulum", SwingInput::logged_torque));
  EXPECT_NE(acting_effect(commanded, "actuation_delay"), nullptr);
  EXPECT_EQ(acting_effect(logged, "actuation_delay"), nullptr);
  EXPECT_NE(acting_effect(logged, "joint_coulomb_friction"), nullptr);
}

}  // namespace
}  // namespace jaculus::testbed
