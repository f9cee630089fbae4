// Two engines that share no physics: the plant (rigid contact found as events, minimal coordinates) and MuJoCo (soft contact, pins
// as constraints, left and right legs). With no effect, leap and drop must agree to less than half the noise floor of motion
// capture (0.3 mm, 0.15 deg); with an effect, both must show the same gap.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "jaculus/effects/effect.h"
#include "jaculus/model/robot.h"
#include "jaculus/simulation/simulate.h"
#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/trials.h"
#include "support/shared_data.h"
#include "testbed/commands.h"
#include "testbed/draws.h"
#include "testbed/mjcf.h"

namespace jaculus {
namespace {

const std::filesystem::path kModels = std::filesystem::path(JACULUS_SOURCE_DIR) / "models";
constexpr double kHalfPosition = 0.15e-3;                        // [m]
constexpr double kHalfAngle = 0.075 * std::numbers::pi / 180.0;  // [rad]

/// x from rest, z, pitch from rest; rows, at the times of the MuJoCo run's motion capture.
struct Motion {
  Vector time;
  Matrix base;
};

testbed::TrialSpec exact_spec(double after) {
  testbed::TrialSpec spec;
  spec.exact = true;
  spec.trials = 1;
  spec.after = after;
  return spec;
}

Motion on_testbed(const Dataset& asked, const testbed::Changes& changes, double after) {
  const Dataset run = testbed::run_trials(asked, changes, exact_spec(after));
  const Stream& mocap = *run.trials.front().stream("mocap");
  return {mocap.time, mocap.values};
}

Motion on_plant(const Dataset& asked, const Effect* effect, const Vector& theta, const Vector& time) {
  const PlanarModel model = read_robot(find_robot(asked.robot, kModels)).planar;
  Plant plant = nominal_plant(model);
  for (const auto& [joint, stop] : asked.stops) plant.stops.push_back({joint, stop.range, stop.restitution});
  if (effect != nullptr) effect->apply(theta, plant);
  Controller controller = stated_controller(asked, model, {});
  controller.after_end = asked.controller.after_end == "repeat" ? AfterEnd::repeat : AfterEnd::hold;
  StartState start = reference_start(plant, controller.reference);
  if (const auto z = asked.initial.find("z"); z != asked.initial.end())
    start.q[model.coordinate_index("z")] = z->second;
  SimulationOptions options;
  options.duration = time[time.size() - 1];
  options.sample_times = time;
  options.relative_tolerance = 1e-8;
  options.absolute_tolerance = 1e-10;
  const Simulation run = simulate(plant, controller, start, options);
  EXPECT_EQ(run.status, SimulationStatus::done) << run.message;
  Motion motion{time, Matrix(3, time.size())};
  int row = 0;
  for (const char* name : {"x", "z", "pitch"}) motion.base.row(row++) = run.q.row(model.coordinate_index(name));
  for (const int i : {0, 2}) motion.base.row(i).array() -= motion.base(i, 0);
  return motion;
}

void expect_agreement(const Dataset& asked, double after) {
  const Motion bench = on_testbed(asked, {}, after);
  const Motion plant = on_plant(asked, nullptr, {}, bench.time);
  const Matrix difference = bench.base - plant.base;
  EXPECT_LT(difference.row(0).cwiseAbs().maxCoeff(), kHalfPosition) << "x";
  EXPECT_LT(difference.row(1).cwiseAbs().maxCoeff(), kHalfPosition) << "z";
  EXPECT_LT(difference.row(2).cwiseAbs().maxCoeff(), kHalfAngle) << "pitch";
}

TEST(Agreement, LeapsOfThreePlansByTorqueAndByDuty) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  JACULUS_REQUIRE_SHARED_DATA(data);
  for (const std::string plan : {"notail_V7", "aerotail_V7_nodes82", "inactivetail_V7"}) {
    for (const std::string quantity : {"torque", "duty"}) {
      SCOPED_TRACE(plan + " " + quantity);
      const auto robot = kModels / (plan == "notail_V7" ? "minitaur" : "minitaur_tail");
      expect_agreement(testbed::leap(robot, data / "plans" / (plan + ".csv"), quantity), 0.08);
    }
  }
}

/// Contacts that rattle unload one foot of a pair at random, and a leg near its shortest then goes another way than its twin.
TEST(Testbed, KeepsLeftAndRightLegsTogetherWhateverTheEncodersSay) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  JACULUS_REQUIRE_SHARED_DATA(data);
  const testbed::RobotFiles files = testbed::read_robot_files(kModels / "minitaur_tail");
  const Dataset asked = testbed::leap(kModels / "minitaur_tail", data / "plans" / "inactivetail_V7.csv", "torque");
  testbed::PlanCommands plan = testbed::plan_commands(*asked.plan, files, "torque", "plan.csv");
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
    const testbed::Recording r = testbed::play(files, {}, plan.commands, options, testbed::Numerics{});
    ASSERT_FALSE(r.diverged);
    for (std::size_t i = 1; i < r.motors.size(); ++i) {
      if (r.motor_of[i] != r.motor_of[i - 1]) continue;
      const auto right = static_cast<Eigen::Index>(i);
      EXPECT_LT((r.position.row(right) - r.position.row(right - 1)).cwiseAbs().maxCoeff(), 2e-3) << seed << r.motors[i];
    }
  }
}

TEST(Testbed, SaysWhereSlippingFeetPartLeftAndRightLegs) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Dataset asked = testbed::leap(kModels / "minitaur_tail", data / "plans" / "inactivetail_V7.csv", "duty");
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
  const testbed::Stage stage{"self_righting", testbed::self_righting(kModels / "minitaur_tail"), true};
  const testbed::Signatures signatures = testbed::signatures_of(stage, {});
  testbed::TrialSpec spec, moved;
  moved.start_offset["tail"] = 1e-3;
  const Dataset nominal = *testbed::exact_run(stage, {}, spec);
  EXPECT_LT(testbed::share_beyond_nuisances(signatures, spec, nominal, *testbed::exact_run(stage, {}, moved)), 0.1);
  testbed::Changes friction;
  friction.tail_friction.coulomb = 0.3;
  EXPECT_GT(testbed::share_beyond_nuisances(signatures, spec, nominal, *testbed::exact_run(stage, friction, spec)),
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

/// The same name and number mean the same thing on both: the difference that is left is small beside the effect itself.
TEST_P(EffectAgreement, TheSameNumberMakesTheSameGap) {
  if (!testbed::available()) GTEST_SKIP() << "built without MuJoCo";
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Dataset asked = testbed::leap(kModels / "minitaur_tail", data / "plans" / "aerotail_V7_nodes82.csv", "duty");
  const testbed::BenchEffect* bench_effect = testbed::find_bench_effect(GetParam().effect);
  const Effect* effect = find_effect(GetParam().effect);
  ASSERT_NE(bench_effect, nullptr);
  ASSERT_NE(effect, nullptr);
  Vector theta = effect->nominal();
  std::vector<double> values;
  for (const testbed::BenchParameter& p : bench_effect->parameters) values.push_back(p.usual);
  values[0] = GetParam().value;
  for (std::size_t i = 0; i < values.size(); ++i) theta[static_cast<Eigen::Index>(i)] = values[i];
  testbed::Changes changes;
  bench_effect->apply(values, changes);
  const Motion still = on_testbed(asked, {}, 0.05), bench = on_testbed(asked, changes, 0.05);
  const Motion plant = on_plant(asked, effect, theta, bench.time);
  const Vector floor = Eigen::Vector3d(2.0 * kHalfPosition, 2.0 * kHalfPosition, 2.0 * kHalfAngle);
  const auto size = [&](const Matrix& m) {
    return std::sqrt((floor.cwiseInverse().asDiagonal() * m).squaredNorm() / static_cast<double>(m.size()));
  };
  const double gap = size(bench.base - still.base), left = size(bench.base - plant.base);
  EXPECT_GT(gap, 1.0) << "the effect is too small to tell anything";
  EXPECT_LT(left, 0.15 * gap + 0.2) << "gap " << gap;
}

INSTANTIATE_TEST_SUITE_P(
    Catalogue, EffectAgreement,
    ::testing::Values(Pair{"tail_compliance", 0.01}, Pair{"tail_coulomb_friction", 2.0},
                      Pair{"leg_coulomb_friction", 0.1}, Pair{"leg_viscous_friction", 0.01},
                      Pair{"leg_load_friction", 0.1}, Pair{"torque_constant", 0.93}, Pair{"voltage_limit", 0.1},
                      Pair{"battery_sag", 0.03}, Pair{"winding_heating", 30.0}, Pair{"drag_coefficient", 1.8},
                      Pair{"drag_without_translation", 1.0}, Pair{"wind", 1.5}, Pair{"leg_rotor_inertia", 3e-4},
                      Pair{"tail_link_mass", 1.25}, Pair{"leg_link_inertia", 2.0}, Pair{"payload", 0.5},
                      Pair{"com_shift", 0.015}, Pair{"body_inertia", 1.9}, Pair{"foot_radius", 0.005}),
    [](const auto& info) { return std::string(info.param.effect); });

}  // namespace
}  // namespace jaculus
