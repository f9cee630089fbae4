// The testbed on robots that are not the Minitaur: everything that it needs of one is in its files.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <regex>

#include "jaculus/model/propose.h"
#include "jaculus/model/urdf.h"
#include "jaculus/testbed/blinded_cases.h"
#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/robot_notes.h"
#include "support/input_error.h"
#include "support/robot_texts.h"
#include "support/temporary_folder.h"
#include "testbed/both_engines.h"
#include "testbed/draws.h"
#include "testbed/sizes.h"
#include "testbed/static_tests.h"

namespace jaculus::testbed {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

const fs::path kHopper = source_folder() / "examples" / "hopper";
const fs::path kLizard = source_folder() / "tests" / "data" / "lizard";

/// The hopper straightens its leg from a crouch of 100 deg to 30 deg within 0.15 s, the foot under
/// the hip; the joints follow by feedback alone.
trajectory::Table hop() {
  constexpr double kDuration = 0.15, kCrouch = 100.0 * test::kDegree,
                   kStraight = 30.0 * test::kDegree;
  constexpr int kSamples = 76;
  trajectory::Table plan;
  plan.columns = {{"time", "s"},
                  {"x", "m"},
                  {"z", "m"},
                  {"pitch", "rad"},
                  {"hip", "rad"},
                  {"knee", "rad"},
                  {"hip_velocity", "rad/s"},
                  {"knee_velocity", "rad/s"},
                  {"hip_torque", "N m"},
                  {"knee_torque", "N m"}};
  plan.values = Matrix::Zero(kSamples, count_of(plan.columns));
  for (int k = 0; k < kSamples; ++k) {
    const double share = k / (kSamples - 1.0), phase = std::numbers::pi * share;
    const double knee = kCrouch + 0.5 * (kStraight - kCrouch) * (1.0 - std::cos(phase));
    const double rate =
        0.5 * (kStraight - kCrouch) * std::sin(phase) * std::numbers::pi / kDuration;
    plan.values.row(k) << share * kDuration, 0.0, 0.4 * std::cos(0.5 * knee), 0.0, -0.5 * knee,
        knee, -0.5 * rate, rate, 0.0, 0.0;
  }
  return plan;
}

class HopperOnBothEngines : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!available()) GTEST_SKIP() << "built without MuJoCo";
    trajectory::write_csv(hop(), folder_ / "plan.csv");
    asked_ = leap(kHopper, folder_ / "plan.csv", trajectory::Quantity::torque);
  }

  test::TemporaryFolder folder_;
  trajectory::Dataset asked_;
};

TEST_F(HopperOnBothEngines, AgreesToHalfTheNoiseFloor) { test::expect_agreement(asked_, 0.03); }

TEST_F(HopperOnBothEngines, ShowsTheSameGapOfAnEffect) {
  test::expect_the_same_gap(asked_, "torque_constant", 0.8, 0.03);
  test::expect_the_same_gap(asked_, "leg_coulomb_friction", 1.0, 0.03);
  test::expect_the_same_gap(asked_, "payload", 0.4, 0.03);
}

TEST_F(HopperOnBothEngines, HasEffectsOnItsLegAndNoneOnATail) {
  const auto effects = bench_effects(kHopper);
  for (const BenchEffect& effect : effects) {
    EXPECT_FALSE(effect.name.starts_with("tail_")) << effect.name;
    EXPECT_NE(effect.component, "tail_aerodynamics") << effect.name;
  }
  EXPECT_NE(find_bench_effect(effects, "leg_load_friction"), nullptr);
  const BenchEffect* offset = find_bench_effect(effects, "leg_offset");
  ASSERT_NE(offset, nullptr);
  ASSERT_EQ(offset->parameters.size(), 1U) << "legs under one hip are rear ones";
  EXPECT_EQ(offset->parameters.front().name, "rear");

  Changes changes;
  offset->apply({0.05}, changes);
  EXPECT_EQ(changes.joint_offset, (std::map<std::string, double>{{"hip", 0.05}, {"knee", 0.05}}));
  EXPECT_TRUE(test::holds(test::input_error_of([] { (void)self_righting(kHopper); }), "no tail"));
}

/// A quadruped as `robot import` writes it: abduction held, pairs of joints alone, knees that rub.
/// Its legs straighten within 0.15 s, feet under the hips.
TEST(ImportedQuadruped, AgreesToHalfTheNoiseFloor) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const test::TemporaryFolder folder;
  const std::string urdf = std::regex_replace(
      test::quadruped_urdf(), std::regex("(upper=\"-0.9\" effort=\"25\" velocity=\"20\"/>)"),
      "$1<dynamics damping=\"0.1\" friction=\"0.3\"/>");
  const model::Proposal proposal = model::propose_robot(model::parse_urdf(urdf, "robot.urdf"));
  folder.write("robot.urdf", urdf);
  folder.write("robot.yaml", proposal.yaml);
  const RobotFiles files = read_robot_files(folder.path());
  EXPECT_EQ(files.toes.size(), 4U);  // of left and right legs
  EXPECT_EQ(files.drives.front().motor.dry_friction + files.drives.back().motor.dry_friction, 0.3);

  trajectory::Table plan = hop();
  plan.columns.resize(4);
  // the knee from 99 to 57 deg, within its range
  const double straight = plan.values(plan.values.rows() - 1, 5);
  const Vector knee = -(1.0 + 0.6 * (plan.values.col(5).array() - straight)).matrix();
  const Vector rate = -0.6 * plan.values.col(7);
  Matrix values(plan.values.rows(), 16);
  values.leftCols(4) = plan.values.leftCols(4);
  values.col(2) = 0.4 * (0.5 * knee.array()).cos();
  int at = 4;
  for (const char* leg : {"front", "rear"}) {
    for (const auto& [joint, share] : {std::pair{"hip", -0.5}, std::pair{"knee", 1.0}}) {
      const std::string name = fmt::format("{}_{}", leg, joint);
      plan.columns.push_back({name, "rad"});
      plan.columns.push_back({name + "_velocity", "rad/s"});
      plan.columns.push_back({name + "_torque", "N m"});
      values.col(at++) = share * knee;
      values.col(at++) = share * rate;
      values.col(at++).setZero();
    }
  }
  plan.values = values;
  trajectory::write_csv(plan, folder / "plan.csv");
  test::expect_agreement(leap(folder.path(), folder / "plan.csv", trajectory::Quantity::torque),
                         0.03);
}

/// Of the quadruped's front feet, two links fixed below a shank each, in an order of their own.
std::string with_fixed_links(const std::vector<std::string>& left,
                             const std::vector<std::string>& right) {
  std::string links;
  const auto add = [&links](const std::string& shank, const std::string& name) {
    links += fmt::format(
        "<link name=\"{0}\"/><joint name=\"{0}_fixed\" type=\"fixed\"><parent link=\"{1}\"/>"
        "<child link=\"{0}\"/></joint>",
        name, shank);
  };
  for (const std::string& name : left) add("FL_shank", name);
  for (const std::string& name : right) add("FR_shank", name);
  return std::regex_replace(test::quadruped_urdf(), std::regex("</robot>"), links + "</robot>");
}

struct OnTestbed {
  RobotFiles files;
  std::vector<std::string> notes;
};

OnTestbed imported(const std::string& urdf) {
  const test::TemporaryFolder folder;
  folder.write("robot.urdf", urdf);
  folder.write("robot.yaml", model::propose_robot(model::parse_urdf(urdf, "robot.urdf")).yaml);
  return {read_robot_files(folder.path()), notes_on_robot(folder.path())};
}

TEST(ImportedQuadruped, FixedLinksArePairedByTheirNamesWhateverTheirOrder) {
  const auto [files, notes] =
      imported(with_fixed_links({"FL_cap", "FL_guard"}, {"FR_guard", "FR_cap"}));
  EXPECT_EQ(files.link_pairs.at("FR_cap"), "FL_cap");
  EXPECT_EQ(files.link_pairs.at("FR_guard"), "FL_guard");
  EXPECT_TRUE(notes.empty()) << notes.front();
}

TEST(ImportedQuadruped, WhatNamesOfFixedLinksDontTellIsSaid) {
  const auto [files, notes] =
      imported(with_fixed_links({"FL_cap", "part_1"}, {"part_2", "FR_cap"}));
  EXPECT_EQ(files.link_pairs.at("FR_cap"), "FL_cap");
  EXPECT_EQ(files.link_pairs.at("part_2"), "part_1");
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_TRUE(test::holds(notes.front(), "'part_1' and 'part_2' are taken as left"));

  const OnTestbed uneven = imported(with_fixed_links({"FL_cap", "sensor"}, {"FR_cap"}));
  EXPECT_EQ(uneven.files.link_pairs.at("FR_cap"), "FL_cap");
  EXPECT_EQ(uneven.files.link_pairs.count("sensor"), 0U);
  ASSERT_EQ(uneven.notes.size(), 1U);
  EXPECT_TRUE(test::holds(uneven.notes.front(), "'sensor' has none on the other side"));
}

TEST(Lizard, ItsLimbsAreFoundByWhatTheyCarry) {
  const RobotFiles files = read_robot_files(kLizard);
  EXPECT_EQ(files.motors_of(Limb::tail), Names{"root"});
  EXPECT_EQ(files.motors_of(Limb::front_leg), Names{"fore"});
  EXPECT_EQ(files.motors_of(Limb::rear_leg), Names{"hind"});
  EXPECT_EQ(files.motors_of(Limb::other), Names{});
  EXPECT_EQ(files.sides_of("hind").size(), 2U);

  const Sizes sizes = sizes_of(files);
  EXPECT_DOUBLE_EQ(sizes.tail.torque, 0.6 * 3.0 * 0.9);
  EXPECT_DOUBLE_EQ(sizes.legs.torque, 0.5 * 6.0 * 0.9);
  EXPECT_DOUBLE_EQ(sizes.length, 0.14);
  EXPECT_DOUBLE_EQ(sizes.voltage, 12.0);
}

TEST(Lizard, DropsAsOnThePlant) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const trajectory::Dataset asked = self_righting(kLizard);
  EXPECT_EQ(asked.stops.at("root").range.upper, 1.3);
  test::expect_agreement(asked, 0.0);
  test::expect_the_same_gap(asked, "drag_coefficient", 2.0, 0.0);
  test::expect_the_same_gap(asked, "tail_coulomb_friction", 0.2, 0.0);
}

double measured_on_lizard(const std::string& name, double value) {
  const RobotFiles files = read_robot_files(kLizard);
  const auto effects = bench_effects(files);
  const BenchEffect& effect = *find_bench_effect(effects, name);
  std::vector<double> values = usual_values(effect);
  values[0] = value;
  Changes changes;
  effect.apply(values, changes);
  return measured_parameters(name, values, files, changes)[0];
}

TEST(Lizard, ATailThatPointsToTheRearBendsAndRattlesAsBuilt) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  EXPECT_NEAR(measured_on_lizard("tail_compliance", 0.05), 0.05, 0.01 * 0.05);
  EXPECT_NEAR(measured_on_lizard("tail_backlash", 0.02), 0.02, 0.03 * 0.02);
  EXPECT_NEAR(measured_on_lizard("tail_stop_restitution", 0.5), 0.5, 0.05);
}

TEST(Lizard, CasesAreBlindedOnIt) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const test::TemporaryFolder folder;
  BlindingSpec spec;
  spec.none = spec.outside = 1;
  spec.robots = {kLizard};
  spec.seed = 5;
  spec.out = folder / "cases";
  spec.key = folder / "cases.key";
  const auto ids = blind_cases(spec);
  ASSERT_EQ(ids.size(), 2U);

  for (const std::string& id : ids) {
    const trajectory::Dataset dataset = trajectory::read_dataset(spec.out / id);
    EXPECT_TRUE(fs::equivalent(dataset.robot, kLizard)) << dataset.robot;
  }
}

TEST(Minitaur, RangesOfStrengthsAreRoundFiguresOfWhatItHas) {
  struct Range {
    const char* effect;
    double lower, upper;
  };
  const auto effects = bench_effects(test::kModels / "minitaur_tail");
  for (const Range& r :
       {Range{"tail_compliance", 0.0005, 0.04}, Range{"tail_coulomb_friction", 0.005, 2.0},
        Range{"leg_coulomb_friction", 0.005, 0.6}, Range{"leg_stribeck_friction", 0.02, 1.2},
        Range{"battery_sag", 0.0005, 0.15}, Range{"wind", -4.0, 4.0}, Range{"payload", 0.005, 2.0},
        Range{"com_shift", -0.06, 0.06}, Range{"tail_rotor_inertia", 1e-6, 3e-4},
        Range{"leg_rotor_inertia", 2e-6, 4e-4}, Range{"ground_compliance", 3e-6, 3e-4},
        Range{"foot_radius", 0.0005, 0.02}, Range{"tether", 5.0, 2000.0},
        Range{"torque_ripple", 0.003, 0.5}, Range{"sticky_floor", 2.0, 200.0},
        Range{"tail_cable", 0.05, 6.0}, Range{"slipping_belt", 0.05, 2.0},
        Range{"loose_battery", 0.05, 2.5}, Range{"push", 2.0, 150.0}}) {
    const BenchEffect* effect = find_bench_effect(effects, r.effect);
    ASSERT_NE(effect, nullptr) << r.effect;
    EXPECT_EQ(effect->parameters.front().lower, r.lower) << r.effect;
    EXPECT_EQ(effect->parameters.front().upper, r.upper) << r.effect;
  }
  Changes changes;
  find_bench_effect(effects, "current_limit")->apply({0.0}, changes);
  EXPECT_EQ(changes.current_limit, 41.343) << "at the torque limit of 3 N m";
  find_bench_effect(effects, "voltage_limit")->apply({0.0}, changes);
  EXPECT_EQ(changes.voltage_limit, 16.0);
}

}  // namespace
}  // namespace jaculus::testbed
