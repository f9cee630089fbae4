// Proposals of robot.yaml: each is read back, for what counts is the robot that comes of it.

#include "jaculus/model/propose.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "model/support.h"
#include "support/input_error.h"
#include "support/robot_texts.h"

namespace jaculus::model {
namespace {

using test::holds;
using testing::Imported;
using testing::imported;
using testing::joint;
using testing::link;
using testing::names;

TEST(Propose, AQuadrupedWithAbductionIsPlanarByItself) {
  const Imported hound = imported(test::quadruped_urdf());
  const PlanarModel& m = hound.robot.planar;
  EXPECT_TRUE(hound.proposal.floating);
  EXPECT_EQ(names(m.coordinates),
            (std::vector<std::string>{"x", "z", "pitch", "front_hip", "front_knee", "rear_hip",
                                      "rear_knee"}));
  EXPECT_NEAR(m.total_mass(), 6.0 + 4 * (0.5 + 0.8 + 0.2), 1e-12);
  EXPECT_NEAR(m.bodies[0].mass, 8.0, 1e-12);
  // the trunk's, and four hips of 0.5 kg at 0.2 m
  EXPECT_NEAR(m.bodies[0].inertia, 0.08 + 4 * (3e-3 + 0.5 * 0.04), 1e-12);

  ASSERT_EQ(m.feet.size(), 2u);
  EXPECT_EQ(m.feet[0].name, "front_foot");
  EXPECT_EQ(m.feet[0].position, Vec2(0.0, -0.2));
  EXPECT_EQ(m.feet[0].count, 2);
  for (const PlanarMotor& motor : m.motors) EXPECT_EQ(motor.torque_limit, 25.0);
}

TEST(Propose, ForwardFollowsFromTheNamesOfLeftAndRight) {
  std::string text = "<robot name=\"biped\">" + link("trunk", 5, "0 0 0");
  for (const char* side : {"left", "right"}) {
    // left is at -y here, so the file looks along -x
    text += link(std::string(side) + "_leg", 1, "0 0 -0.1", "<sphere radius=\"0.01\"/>") +
            joint(std::string(side) + "_hip", "revolute", "trunk", std::string(side) + "_leg",
                  std::string(side) == "left" ? "0 -0.1 0" : "0 0.1 0", "0 1 0");
  }
  const Imported biped = imported(text + "</robot>");
  EXPECT_TRUE(holds(biped.proposal.yaml, "axes: {forward: -x, up: +z}"));
  EXPECT_TRUE(holds(biped.proposal.yaml, "[\"left_hip\", \"right_hip\"]"));
}

TEST(Propose, SidesThatRubUnlikeHaveTheirMean) {
  std::string text = "<robot name=\"biped\">" + link("trunk", 5, "0 0 0");
  for (const char* side : {"left", "right"}) {
    const bool left = std::string(side) == "left";
    text +=
        link(std::string(side) + "_leg", 1, "0 0 -0.1", "<sphere radius=\"0.01\"/>") +
        testing::replaced(joint(std::string(side) + "_hip", "revolute", "trunk",
                                std::string(side) + "_leg", left ? "0 0.1 0" : "0 -0.1 0", "0 1 0"),
                          "</joint>",
                          left ? "<dynamics damping=\"0.1\" friction=\"2\"/></joint>"
                               : "<dynamics damping=\"0.3\" friction=\"3\"/></joint>");
  }
  const Imported biped = imported(text + "</robot>");
  const PlanarMotor& motor = biped.robot.planar.motors.at(0);
  EXPECT_EQ(motor.count, 2);
  EXPECT_NEAR(motor.viscous_friction, 0.2, 1e-12);
  EXPECT_NEAR(motor.dry_friction, 2.5, 1e-12);
  bool said = false;
  for (const std::string& note : biped.proposal.notes)
    said = said || holds(note,
                         "'left_hip' and 'right_hip' differ in damping, 0.1 and 0.3, or "
                         "friction, 2 and 3 (SI): their mean counts");
  EXPECT_TRUE(said);
}

TEST(Propose, SaysWhatIsDropped) {
  const Dropped d = imported(test::quadruped_urdf()).proposal.dropped;
  EXPECT_NEAR(d.mass, 12.0, 1e-12);
  EXPECT_NEAR(d.com_off_plane, 0.0, 1e-15);
  Dropped off;
  off.com_off_plane = -6.28e-5;
  EXPECT_EQ(off.com_sideways(), "0.06 mm to the right");
  EXPECT_NEAR(d.mass_off_plane, 6.0, 1e-12);
  // hips at 0.07 m, thighs at 0.14 m, shanks at 0.13 m from the plane
  EXPECT_NEAR(d.inertia_moved, 4 * (0.5 * 0.07 * 0.07 + 0.8 * 0.14 * 0.14 + 0.2 * 0.13 * 0.13),
              1e-12);
  EXPECT_NEAR(d.coupling, 0.0, 1e-12);
}

TEST(Propose, LeftAndRightMayStayApart) {
  ProposeOptions options;
  options.pairs = false;
  EXPECT_EQ(imported(test::quadruped_urdf(), options).robot.planar.size(), 3 + 8);
}

TEST(Propose, AFileWithYUpAndZForward) {
  // the pendulum hangs along -y, its joints turn about x; two of them, so it isn't one limb
  std::string text = "<robot name=\"r\">" + link("trunk", 5, "0 0 0");
  for (const char* end : {"front", "rear"}) {
    const std::string z = std::string(end) == "front" ? "0.2" : "-0.2";
    text += link(std::string(end) + "_leg", 1, "0 -0.1 0", "<sphere radius=\"0.01\"/>") +
            joint(std::string(end) + "_joint", "revolute", "trunk", std::string(end) + "_leg",
                  "0 -0.1 " + z, "1 0 0") +
            link(std::string(end) + "_toe", 0.1, "0 0 0", "<sphere radius=\"0.01\"/>") +
            joint(std::string(end) + "_ankle", "fixed", std::string(end) + "_leg",
                  std::string(end) + "_toe", "0 -0.3 0", "1 0 0");
  }
  const Imported r = imported(text + "</robot>");
  EXPECT_NE(r.proposal.yaml.find("axes: {forward: +z, up: +y}"), std::string::npos);
  ASSERT_EQ(r.robot.planar.feet.size(), 2u);
  EXPECT_NEAR(r.robot.planar.bodies[1].origin.x(), 0.2, 1e-12);
  EXPECT_NEAR(r.robot.planar.bodies[1].origin.y(), -0.1, 1e-12);
  EXPECT_NEAR(r.robot.planar.feet[0].position.y(), -0.3, 1e-12);
}

TEST(Propose, AnArmIsFixedAndKeepsTheJointsOfThePlane) {
  const Imported arm =
      imported("<robot name=\"arm\">" + link("base", 3, "0 0 0") + link("a", 2, "0 0 0.1") +
               link("b", 2, "0 0 0.1") + link("c", 1, "0 0 0.1") +
               joint("turn", "revolute", "base", "a", "0 0 0.2", "0 0 1") +
               joint("lift", "revolute", "a", "b", "0 0 0.2", "0 1 0") +
               joint("bend", "revolute", "b", "c", "0 0 0.2", "0 -1 0") + "</robot>");
  EXPECT_FALSE(arm.proposal.floating);
  EXPECT_EQ(names(arm.robot.planar.coordinates), (std::vector<std::string>{"lift", "bend"}));
  EXPECT_EQ(arm.robot.planar.bodies[0].mass, 5.0);
  EXPECT_TRUE(arm.robot.planar.feet.empty());
}

TEST(Propose, ThePlaneMayBeStated) {
  const std::string arm = "<robot name=\"arm\">" + link("base", 3, "0 0 0") +
                          link("a", 2, "0 0 0.1") + link("b", 2, "0 0 0.1") +
                          joint("turn", "revolute", "base", "a", "0 0 0.2", "1 0 0") +
                          joint("lift", "revolute", "a", "b", "0 0 0.2", "0 1 0") + "</robot>";
  ProposeOptions options;
  EXPECT_EQ(names(imported(arm, options).robot.planar.coordinates),
            (std::vector<std::string>{"lift"}));
  options.forward = "+y";
  options.up = "+z";
  EXPECT_EQ(names(imported(arm, options).robot.planar.coordinates),
            (std::vector<std::string>{"turn"}));
}

TEST(Propose, AFlatMechanismHasNoGravity) {
  const Imported scara =
      imported("<robot name=\"s\">" + link("base", 3, "0 0 0") + link("a", 2, "0.1 0 0") +
               link("b", 2, "0.1 0 0") + joint("one", "revolute", "base", "a", "0 0 0.2", "0 0 1") +
               joint("two", "revolute", "a", "b", "0.3 0 0", "0 0 1") + "</robot>");
  EXPECT_EQ(scara.robot.planar.gravity, 0.0);
  EXPECT_EQ(scara.robot.planar.size(), 2);
}

TEST(Propose, AWheelIsNoLeg) {
  const auto wheels = [](double com) {
    std::string text = "<robot name=\"car\">" + link("trunk", 5, "0 0 0");
    for (const char* end : {"front", "rear"})
      text += link(std::string(end) + "_wheel", 1, fmt::format("0 0 {}", com)) +
              joint(std::string(end) + "_axle", "continuous", "trunk", std::string(end) + "_wheel",
                    std::string(end) == "front" ? "0.2 0 0" : "-0.2 0 0", "0 1 0");
    return text + "</robot>";
  };
  const Imported car = imported(wheels(0.0));
  EXPECT_TRUE(car.robot.planar.feet.empty());
  EXPECT_TRUE(holds(car.proposal.yaml, "rolling is not modelled"));
  EXPECT_TRUE(holds(car.proposal.missing.at(0), "feet: none was found"));
  // the same with the mass below the axle is a leg, whose foot is a guess
  const Imported legs = imported(wheels(-0.1));
  ASSERT_EQ(legs.robot.planar.feet.size(), 2u);
  EXPECT_NEAR(legs.robot.planar.feet[0].position.y(), -0.2, 1e-12);
  EXPECT_TRUE(holds(legs.proposal.missing.at(0), "feet.front_foot.point"));
}

TEST(Propose, WhatBeginsInTheMiddleIsALegOnlyWhereItReachesTheFloor) {
  const Imported armed = imported(test::quadruped_with_limb(0.2, 0.05, "0.15 0 0"));
  std::vector<std::string> feet;
  for (const PlanarPoint& foot : armed.robot.planar.feet) feet.push_back(foot.name);
  EXPECT_EQ(feet, (std::vector<std::string>{"front_foot", "rear_foot"}));
  EXPECT_TRUE(holds(armed.proposal.yaml, "'shoulder' begins no leg: it is in the middle"));
  EXPECT_GE(armed.robot.planar.motor_index("shoulder"), 0);

  // a fifth leg, as long as the others
  const Imported five = imported(test::quadruped_with_limb(0.0, 0.0, "0 0 -0.2"));
  EXPECT_EQ(five.robot.planar.feet.size(), 3u);
  EXPECT_EQ(five.robot.planar.feet.at(1).name, "middle_foot");
}

TEST(Propose, JointsWithoutAnEffortArePassiveWhereOthersHaveOne) {
  const Imported pole = imported(
      "<robot name=\"p\">" + link("rail", 1, "0 0 0") + link("cart", 1, "0 0 0") +
      link("pole", 1, "0 0 0.3") + joint("slide", "prismatic", "rail", "cart", "0 0 0", "1 0 0") +
      joint("swing", "continuous", "cart", "pole", "0 0 0", "0 1 0", "0") + "</robot>");
  ASSERT_EQ(pole.robot.planar.motors.size(), 1u);
  EXPECT_EQ(pole.robot.planar.motors[0].joint, "slide");
  EXPECT_TRUE(holds(pole.proposal.missing.at(0), "no largest torque of swing"));
}

TEST(Propose, AnInertiaBeyondTheRobotsSizeIsSaid) {
  const std::string ones =
      testing::replaced(test::quadruped_urdf(), "ixx=\"0.02\" iyy=\"0.08\" izz=\"0.09\"",
                        "ixx=\"1\" iyy=\"6\" izz=\"6\"");
  const std::string said = imported(ones).proposal.missing.at(0);
  EXPECT_TRUE(holds(said, "inertias of 1 links"));
  EXPECT_TRUE(holds(said, "--inertias shapes"));
  const std::vector<std::string> usual = imported(test::quadruped_urdf()).proposal.missing;
  ASSERT_EQ(usual.size(), 1u);
  EXPECT_TRUE(holds(usual.front(), "friction: 0.8"));
}

TEST(Propose, NothingThatMovesIsSaid) {
  const Imported box = imported("<robot name=\"b\">" + link("box", 1, "0 0 0") + "</robot>");
  EXPECT_FALSE(box.proposal.planar);
  EXPECT_EQ(box.robot.planar.size(), 3);
}

}  // namespace
}  // namespace jaculus::model
