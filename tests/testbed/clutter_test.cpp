// A cluttered robot: off by its tolerances and no more, alike on both sides, the same for a seed.

#include "testbed/clutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/model/robot.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::testbed {
namespace {

RobotFiles files_of(const std::string& robot) {
  return read_robot_files(model::find_robot(robot, "."));
}

TEST(Clutter, IsWithinTwoStandardDeviationsAndSpreadAsTheToleranceSays) {
  const RobotFiles files = files_of("minitaur_tail");
  const model::Tolerances t = files.tolerances;
  double squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Clutter clutter = draw_clutter(files, t, seed);
    for (const auto& [name, link] : clutter.links) {
      EXPECT_LE(std::abs(link.mass - 1.0), 2.0 * t.mass) << name;
      EXPECT_LE(std::abs(link.length - 1.0), 2.0 * t.length) << name;
    }
    for (const auto& [name, motor] : clutter.motors) {
      EXPECT_LE(std::abs(motor.torque_constant - 1.0), 2.0 * t.torque_constant) << name;
      EXPECT_GE(motor.friction, 0.0);
      squares += std::pow((motor.torque_constant - 1.0) / t.torque_constant, 2);
      ++count;
    }
  }

  // Variance of a normal cut at two standard deviations: 1 - 4 phi(2)/(2 Phi(2) - 1) = 0.774; of
  // 1,000 draws its standard error is 0.03.
  EXPECT_NEAR(squares / count, 0.774, 0.1);
}

TEST(Clutter, IsTheSameForBothSidesOfAPairAndForOneSeed) {
  const RobotFiles files = files_of("minitaur");
  const Clutter one = draw_clutter(files, files.tolerances, 5);

  EXPECT_EQ(one.links.at("front_left_a_upper").mass, one.links.at("front_right_a_upper").mass);
  EXPECT_NE(one.links.at("front_left_a_upper").mass, one.links.at("rear_left_a_upper").mass);
  EXPECT_EQ(one.floor_friction, draw_clutter(files, files.tolerances, 5).floor_friction);
  EXPECT_NE(one.floor_friction, draw_clutter(files, files.tolerances, 6).floor_friction);
}

TEST(Clutter, MovesMassesLengthsMotorsAndFloorOfTheRobot) {
  const RobotFiles files = files_of("minitaur_tail");
  const Clutter clutter = draw_clutter(files, files.tolerances, 3);
  const RobotFiles real = cluttered(files, clutter);

  const int link = files.tree.link_index("front_left_a_lower");
  const LinkClutter by = clutter.links.at("front_left_a_lower");
  EXPECT_DOUBLE_EQ(real.tree.links[link].mass, by.mass * files.tree.links[link].mass);
  EXPECT_DOUBLE_EQ(real.friction, clutter.floor_friction * files.friction);
  EXPECT_NE(real.toes.front().point.z(), files.toes.front().point.z());
  EXPECT_NE(real.drives.front().motor.resistance, files.drives.front().motor.resistance);
  EXPECT_EQ(real.drives.front().motor.torque_constant, files.drives.front().motor.torque_constant)
      << "the driver goes on believing in the stated one";
}

TEST(Clutter, ADefaultBuiltOneIsTheRobotOfItsFiles) {
  const RobotFiles files = files_of("minitaur_tail");
  const RobotFiles real = cluttered(files, Clutter{});

  EXPECT_EQ(real.tree.links.front().mass, files.tree.links.front().mass);
  EXPECT_EQ(real.friction, files.friction);
  EXPECT_EQ(real.drives.back().friction, 0.0);
}

TEST(Clutter, NoEncoderPutsAJointBeyondItsStop) {
  if (!available()) GTEST_SKIP() << "no MuJoCo in this build";
  // The tail begins at its stop. An encoder that reads too much would have it beyond, from where
  // the stop would throw it.
  const std::filesystem::path folder = model::find_robot("minitaur_tail", ".");
  const RobotFiles files = read_robot_files(folder);
  TrialSpec spec;
  spec.trials = 1;
  spec.exact = true;
  double zero = 0.0;
  for (std::uint64_t seed = 1; zero < 3e-3; ++seed) {
    spec.clutter_seed = seed;
    zero = draw_clutter(files, files.tolerances, seed).encoder_zero.at("tail");
  }

  const trajectory::Dataset dataset = run_trials(self_righting(folder), {}, spec);
  const trajectory::Stream& joints = *dataset.trials[0].stream("joints");
  const double stop = dataset.stops.at("tail").range.lower;
  EXPECT_NEAR(joints.values(joints.channel("tail"), 0), stop + zero, 2e-4)
      << "it rests at its stop and reads as its encoder does";
}

TEST(Clutter, MakesAnotherMotionOfTheSamePendulum) {
  if (!available()) GTEST_SKIP() << "no MuJoCo in this build";
  const trajectory::Dataset asked = pendulum(model::find_robot("pendulum", "."));
  TrialSpec spec;
  spec.trials = 1;
  spec.exact = true;
  const trajectory::Dataset plain = run_trials(asked, {}, spec);
  spec.clutter_seed = 4;
  const trajectory::Dataset off = run_trials(asked, {}, spec);

  const Matrix difference =
      off.trials[0].streams[0].values.row(0) - plain.trials[0].streams[0].values.row(0);
  EXPECT_GT(difference.cwiseAbs().maxCoeff(), 1e-4) << "a cluttered pendulum swings otherwise";
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.5) << "but it is the same pendulum";
}

}  // namespace
}  // namespace jaculus::testbed
