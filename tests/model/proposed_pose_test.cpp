// Which joints a proposal holds, and where the others are at rest.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>
#include <string>
#include <vector>

#include "jaculus/model/propose.h"
#include "model/support.h"
#include "support/input_error.h"
#include "support/robot_texts.h"

namespace jaculus::model {
namespace {

using test::holds;
using test::input_error_of;
using testing::Imported;
using testing::imported;
using testing::joint;
using testing::link;

TEST(Propose, RestsWithItsFeetBelowTheHipsAtOneHeight) {
  const Imported hound = imported(test::quadruped_urdf());
  const std::vector<testing::Pose> at = testing::poses(hound.robot.planar, {}, hound.proposal.rest);
  for (const PlanarPoint& foot : hound.robot.planar.feet) {
    const Vec2 p = at[foot.body].at(foot.position);
    EXPECT_NEAR(p.x(), foot.name == "front_foot" ? 0.2 : -0.2, 1e-4);
    EXPECT_NEAR(p.y(), -0.75 * 0.4, 1e-4);
  }
  EXPECT_GE(hound.proposal.rest.at("front_knee"), -2.7);
  EXPECT_LE(hound.proposal.rest.at("front_knee"), -0.9);
}

TEST(Propose, AbductionIsHeldWhereItIsStated) {
  ProposeOptions options;
  for (const char* leg : {"FL", "RL"}) options.pose[std::string(leg) + "_abduct"] = 0.1;
  for (const char* leg : {"FR", "RR"}) options.pose[std::string(leg) + "_abduct"] = -0.1;
  const Imported hound = imported(test::quadruped_urdf(), options);
  // thighs hang from hips that are turned outwards: 0.08 m of abduction link rise
  EXPECT_NEAR(hound.robot.planar.bodies[1].origin.y(), 0.08 * std::sin(0.1), 1e-6);
  EXPECT_EQ(hound.robot.planar.size(), 7);

  options.pose = {{"FL_abdct", 0.1}};
  EXPECT_TRUE(holds(input_error_of([&] { (void)imported(test::quadruped_urdf(), options); }),
                    "did you mean 'FL_abduct'"));
  options.pose = {{"FL_abduct", 2.0}};
  EXPECT_TRUE(holds(input_error_of([&] { (void)imported(test::quadruped_urdf(), options); }),
                    "out of range; allowed: -0.8 to 0.8"));
}

TEST(Propose, JointsOfThePlaneAreHeldWhereAskedFor) {
  const std::string limb = test::quadruped_with_limb(0.2, 0.1, "0.1 0 0.1");
  const Imported usual = imported(limb);
  ASSERT_EQ(usual.robot.planar.coordinates.size(), 9u);
  std::vector<std::string> others;
  for (const PlanarMotor& motor : usual.robot.planar.motors)
    if (!motor.joint.starts_with("front_") && !motor.joint.starts_with("rear_"))
      others.push_back(motor.joint);
  ASSERT_EQ(others.size(), 2u);

  ProposeOptions options;
  options.hold = others;
  const Imported held = imported(limb, options);
  EXPECT_EQ(held.robot.planar.coordinates.size(), 7u);
  EXPECT_TRUE(holds(held.proposal.yaml, "as asked for"));

  // without a motor: loose, unless what is passive is held
  const std::string loose = testing::replaced(
      testing::replaced(limb, "effort=\"1e5\"", "effort=\"0\""), "effort=\"1e5\"", "effort=\"0\"");
  const Imported hanging = imported(loose);
  EXPECT_EQ(hanging.robot.planar.coordinates.size(), 9u);
  EXPECT_TRUE(holds(fmt::format("{}", fmt::join(hanging.proposal.missing, "\n")),
                    "shoulder, wrist; no motor is assumed there, so that they hang loose (--hold"));
  ProposeOptions passive;
  passive.hold_passive = true;
  const Imported stiff = imported(loose, passive);
  EXPECT_EQ(stiff.robot.planar.coordinates.size(), 7u);
  EXPECT_TRUE(holds(fmt::format("{}", fmt::join(stiff.proposal.notes, "\n")),
                    "held, 2 of 14 joints (no motor of their own with a stated limit)"))
      << fmt::format("{}", fmt::join(stiff.proposal.notes, "\n"));

  const std::string undriven =
      std::regex_replace(limb, std::regex("effort=\"[^\"]*\""), "effort=\"0\"");
  EXPECT_TRUE(holds(fmt::format("{}", fmt::join(imported(undriven, passive).proposal.notes, "\n")),
                    "`--hold passive` holds nothing"));

  ProposeOptions wrong;
  wrong.hold = {"sholder"};
  EXPECT_TRUE(holds(input_error_of([&] { (void)imported(limb, wrong); }),
                    "--hold: no joint 'sholder' moves, did you mean 'shoulder'?"));
}

TEST(Propose, RestsAsItsFileSaysWhereItStandsInThatPose) {
  ProposeOptions options;
  for (const char* leg : {"FL", "FR", "RL", "RR"}) {
    options.file_pose[std::string(leg) + "_hip_joint"] = 0.8;
    options.file_pose[std::string(leg) + "_knee_joint"] = -1.6;
  }
  const Imported standing = imported(test::quadruped_urdf(), options);
  EXPECT_EQ(standing.proposal.rest.at("front_hip"), 0.8);
  EXPECT_EQ(standing.proposal.rest.at("rear_knee"), -1.6);

  // front legs lifted before the robot, as a keyframe to lie in has them
  for (const char* leg : {"FL", "FR"}) options.file_pose[std::string(leg) + "_hip_joint"] = 3.0;
  const Imported lying = imported(test::quadruped_urdf(), options);
  const Imported drawn_in = imported(test::quadruped_urdf());
  EXPECT_EQ(lying.proposal.rest, drawn_in.proposal.rest);
  const std::string notes = fmt::format("{}", fmt::join(lying.proposal.notes, "\n"));
  EXPECT_TRUE(holds(notes, "the file's pose is none to stand in"));

  // what the user states counts
  options.pose["FL_hip_joint"] = 0.6;
  EXPECT_EQ(imported(test::quadruped_urdf(), options).proposal.rest.at("front_hip"), 0.6);
}

TEST(Propose, ARestPoseAtARangesEndIsReadBackWithinIt) {
  // ends in degrees have more digits than a person writes
  for (const double degrees : {0.4, 7.3, 29.0, 57.0, 61.9, 103.7}) {
    for (const double sense : {1.0, -1.0}) {
      const double end = sense * degrees * M_PI / 180.0;
      const std::string range =
          fmt::format("lower=\"{}\" upper=\"{}\"", std::min(end, 2 * end), std::max(end, 2 * end));
      const std::string text = testing::replaced(
          "<robot name=\"r\">" + link("base", 5, "0 0 0") + link("arm", 1, "0 0 -0.1") +
              joint("turn", "revolute", "base", "arm", "0 0 0", "0 1 0") + "</robot>",
          "lower=\"-2\" upper=\"2\"", range);
      const Imported robot = imported(text);
      const Bounds& allowed = robot.robot.planar.coordinates.back().range;
      const double rest = robot.robot.rest_pose.at("turn");
      EXPECT_TRUE(allowed.contains(rest)) << fmt::format("{}: {}", end, rest);
      EXPECT_NEAR(rest, end, 1e-5);  // six digits of it
    }
  }
}

}  // namespace
}  // namespace jaculus::model
