// Proposals of robot.yaml: each is read back, for what counts is the robot that comes of it.

#include "jaculus/model/propose.h"

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>

#include "jaculus/model/mjcf.h"
#include "jaculus/model/robot.h"
#include "model/support.h"
#include "support/input_error.h"
#include "support/robot_texts.h"

namespace jaculus::model {
namespace {

using test::holds;
using test::input_error_of;

struct Imported {
  Proposal proposal;
  Robot robot;
};

Imported imported(const std::string& urdf, const ProposeOptions& options = {}) {
  const testing::Folder folder;
  const Proposal proposal = propose_robot(parse_urdf(urdf, "robot.urdf"), options);
  folder.write("robot.urdf", urdf);
  folder.write("robot.yaml", proposal.yaml);
  return {proposal, read_robot(folder.path())};
}

std::vector<std::string> names(const std::vector<Coordinate>& coordinates) {
  std::vector<std::string> all;
  for (const Coordinate& c : coordinates) all.push_back(c.name);
  return all;
}

std::string link(const std::string& name, double mass, const std::string& com,
                 const std::string& shape = "") {
  return fmt::format(
      "<link name=\"{}\"><inertial><origin xyz=\"{}\"/><mass value=\"{}\"/><inertia ixx=\"0.01\" "
      "iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{}</link>\n",
      name, com, mass,
      shape.empty() ? "" : "<collision><geometry>" + shape + "</geometry></collision>");
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& origin, const std::string& axis,
                  const std::string& effort = "10") {
  return fmt::format(
      "<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/><origin "
      "xyz=\"{}\"/><axis "
      "xyz=\"{}\"/><limit lower=\"-2\" upper=\"2\" effort=\"{}\" velocity=\"9\"/></joint>\n",
      name, type, parent, child, origin, axis, effort);
}

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

Proposal proposed_of(const std::filesystem::path& file) {
  const MjcfRobot robot = read_mjcf(file);
  ProposeOptions options;
  options.surfaces = robot.surfaces;
  return propose_robot(robot.tree, options);
}

/// The hopper, or nothing where this build has no MuJoCo.
std::optional<MjcfRobot> hopper() {
  const testing::Folder folder;
  folder.write("hopper.xml", test::kHopperMjcf);
  EXPECT_TRUE(is_mjcf(folder.path() / "hopper.xml"));
  try {
    return read_mjcf(folder.path() / "hopper.xml");
  } catch (const InputError& error) {
    EXPECT_TRUE(holds(error.what(), "made without it"));
    return {};
  }
}

TEST(Mjcf, IsReadByMujocoWithGeomsInertiasAndActuators) {
  const std::optional<MjcfRobot> mjcf = hopper();
  if (!mjcf) GTEST_SKIP() << "no MuJoCo";
  const SpatialTree& tree = mjcf->tree;
  const SpatialLink& trunk = tree.links[tree.link_index("trunk")];
  // a box of 4 kg, 0.2 x 0.1 x 0.3 m
  EXPECT_NEAR(trunk.inertia(1, 1), 4.0 / 12.0 * (0.2 * 0.2 + 0.3 * 0.3), 1e-12);
  EXPECT_EQ(tree.joints[tree.joint_index("hip")].effort, 50.0);
  EXPECT_EQ(tree.joints[tree.joint_index("knee")].effort, 30.0);
  EXPECT_EQ(mjcf->armature.at("hip"), 0.02);
  EXPECT_FALSE(mjcf->floating);
}

TEST(Mjcf, OfANewerFileWhatMujocoDoesNotKnowIsLeftOutAndSaid) {
  if (!hopper()) GTEST_SKIP() << "no MuJoCo";
  std::string newer = test::kHopperMjcf;
  newer =
      testing::replaced(newer, "<worldbody>",
                        "<option integrator=\"soon\"/>\n<statistic glitter=\"1\"/>\n<worldbody>");
  const testing::Folder folder;
  folder.write("hopper.xml", newer);
  const MjcfRobot robot = read_mjcf(folder.path() / "hopper.xml");
  const std::string notes = fmt::format("{}", fmt::join(robot.notes, "\n"));
  EXPECT_TRUE(holds(notes, "assumed: no autolimits"));
  EXPECT_TRUE(holds(notes, "assumed: 'soon' of <option>, which MuJoCo"));
  EXPECT_TRUE(holds(notes, "assumed: 'glitter' of <statistic>, which MuJoCo"));

  // the robot is the same
  const MjcfRobot same = *hopper();
  EXPECT_EQ(write_urdf(robot.tree), write_urdf(same.tree));
  EXPECT_THROW((void)read_mjcf(folder.path() / "hopper.xml", Reading::strict), InputError);
  // what is no matter of versions is refused as it was
  folder.write("hopper.xml",
               testing::replaced(newer, "<worldbody>", "<worldbody><body mass=\"1\""));
  EXPECT_THROW((void)read_mjcf(folder.path() / "hopper.xml"), InputError);
}

TEST(Mjcf, WithoutItsMeshesIsReadWhereLinksStateTheirInertias) {
  const std::optional<MjcfRobot> usual = hopper();
  if (!usual) GTEST_SKIP() << "no MuJoCo";
  const std::string drawn =
      testing::replaced(test::kHopperMjcf, "<worldbody>",
                        "<asset><mesh name=\"shell\" file=\"shell.stl\"/></asset>\n<worldbody>");
  const std::string inertial =
      "<inertial pos=\"0 0 0\" mass=\"4\" diaginertia=\"0.03 0.04 0.02\"/>";
  const std::string box = "<geom name=\"box\"";
  const std::string shell = "<geom type=\"mesh\" mesh=\"shell\"/>";
  const testing::Folder folder;
  folder.write("hopper.xml", testing::replaced(drawn, box, inertial + shell + box));
  const MjcfRobot robot = read_mjcf(folder.path() / "hopper.xml");
  const std::string notes = fmt::format("{}", fmt::join(robot.notes, "\n"));
  EXPECT_TRUE(holds(notes, "a mesh whose file isn't there"));
  const SpatialTree& tree = robot.tree;
  EXPECT_NEAR(tree.links[tree.link_index("trunk")].inertia(1, 1), 0.04, 1e-12);
  EXPECT_THROW((void)read_mjcf(folder.path() / "hopper.xml", Reading::strict), InputError);

  // a link that has its mass from the mesh can't do without
  folder.write("hopper.xml", testing::replaced(drawn, box, shell + box));
  try {
    (void)read_mjcf(folder.path() / "hopper.xml");
    ADD_FAILURE() << "read";
  } catch (const InputError& error) {
    EXPECT_TRUE(holds(error.what(), "the file of mesh 'shell' isn't there"));
  }
}

TEST(Mjcf, WithoutAMeshALinkKeepsItsStatedMassWhereGeomsGiveMasses) {
  if (!hopper()) GTEST_SKIP() << "no MuJoCo";
  const auto inertial = [](double mass) {
    return fmt::format("<inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"0.03 0.04 0.02\"/>",
                       mass);
  };
  std::string text = testing::replaced(test::kHopperMjcf, "<compiler angle=\"radian\"/>",
                                       "<compiler angle=\"radian\" inertiafromgeom=\"true\"/>"
                                       "<asset><mesh name=\"shell\" file=\"shell.stl\"/></asset>");
  text =
      testing::replaced(text, "<geom name=\"box\"",
                        inertial(6.0) + "<geom type=\"mesh\" mesh=\"shell\"/><geom name=\"box\"");
  text =
      testing::replaced(text, "<geom type=\"capsule\"", inertial(9.0) + "<geom type=\"capsule\"");
  const testing::Folder folder;
  folder.write("hopper.xml", text);
  const MjcfRobot robot = read_mjcf(folder.path() / "hopper.xml");

  const auto mass = [&](const char* link) {
    return robot.tree.links[robot.tree.link_index(link)].mass;
  };
  EXPECT_EQ(mass("trunk"), 6.0) << "4 kg of its box are not all of it";
  EXPECT_EQ(mass("thigh"), 1.0) << "of its geom, as MuJoCo has it";
  EXPECT_TRUE(holds(fmt::format("{}", fmt::join(robot.notes, "\n")),
                    "a mesh of link 'trunk' isn't there: the link's own <inertial> counts, 6 kg"));
}

TEST(Mjcf, ComesBackFromItsUrdfAndIsPlanar) {
  const std::optional<MjcfRobot> mjcf = hopper();
  if (!mjcf) GTEST_SKIP() << "no MuJoCo";
  ProposeOptions options;
  options.armature = mjcf->armature;
  const Imported robot = imported(write_urdf(mjcf->tree), options);
  const PlanarModel& m = robot.robot.planar;
  EXPECT_EQ(m.bodies[0].name, "trunk");
  EXPECT_EQ(names(m.coordinates), (std::vector<std::string>{"x", "z", "pitch", "hip", "knee"}));
  EXPECT_NEAR(m.total_mass(), 5.5, 1e-12);
  // the hip's anchor is 0.05 m above the thigh's frame, so its link begins there
  EXPECT_NEAR(m.bodies[1].origin.y(), -0.15, 1e-12);
  EXPECT_NEAR(m.bodies[1].com.y(), -0.15 - 0.05, 1e-12);
  EXPECT_NEAR(m.bodies[2].origin.y(), -0.35, 1e-12);
  EXPECT_EQ(m.bodies[2].sign, -1.0);
  EXPECT_EQ(m.motors[0].rotor_inertia, 0.02);
  EXPECT_EQ(m.motors[0].viscous_friction, 0.1);
  EXPECT_EQ(m.motors[1].viscous_friction, 0.0);
}

TEST(Propose, ACapsulesFootIsItsLowestPointAtRest) {
  const std::optional<MjcfRobot> mjcf = hopper();
  if (!mjcf) GTEST_SKIP() << "no MuJoCo";
  const Imported robot = imported(write_urdf(mjcf->tree));
  const PlanarModel& m = robot.robot.planar;
  ASSERT_EQ(m.feet.size(), 1u);

  // the shank ends in a cap of 0.02 m about (0, -0.3)
  const Vec2 from_cap = m.feet[0].position - Vec2(0.0, -0.3);
  EXPECT_NEAR(from_cap.norm(), 0.02, 1e-6);
  const std::vector<testing::Pose> at = testing::poses(m, {}, robot.proposal.rest);
  const testing::Pose& shank = at[static_cast<std::size_t>(m.feet[0].body)];
  const Vec2 down = shank.at(m.feet[0].position) - shank.at(Vec2(0.0, -0.3));
  EXPECT_NEAR(down.x(), 0.0, 1e-6);
  EXPECT_NEAR(down.y(), -0.02, 1e-6);

  // links of 0.35 and 0.3 m and the cap, drawn in to three quarters, below the hip
  EXPECT_NEAR(shank.at(m.feet[0].position).y(), -0.15 - 0.75 * (0.35 + 0.3 + 0.02), 1e-4);
  EXPECT_TRUE(holds(fmt::format("{}", fmt::join(robot.proposal.notes, "\n")), "doesn't roll"));
}

TEST(Mjcf, FeetHaveTheFrictionOfTheirGeoms) {
  const std::optional<MjcfRobot> usual = hopper();
  if (!usual) GTEST_SKIP() << "no MuJoCo";
  const Proposal assumed = propose_robot(usual->tree, {});
  EXPECT_TRUE(holds(assumed.yaml, "friction: 0.8   # fill in"));
  EXPECT_TRUE(holds(assumed.missing.at(0), "friction: 0.8"));

  const std::string foot = "size=\"0.02\" mass=\"0.5\"", floor = "size=\"5 5 1\"";
  const auto with = [&](const std::string& of_foot, const std::string& of_floor) {
    const testing::Folder folder;
    folder.write("hopper.xml",
                 testing::replaced(testing::replaced(test::kHopperMjcf, foot, foot + " " + of_foot),
                                   floor, floor + " " + of_floor));
    return proposed_of(folder.path() / "hopper.xml");
  };
  // the larger of both, unless one has priority
  const Proposal stated = with("friction=\"0.6\"", "friction=\"0.3\"");
  EXPECT_TRUE(holds(stated.yaml,
                    "friction: 0.6   # of the feet, by the file: 'foot' (0.6) on 'world' (0.3), "
                    "of which MuJoCo takes the larger"))
      << stated.yaml;
  for (const std::string& line : stated.missing) EXPECT_FALSE(holds(line, "friction: 0.8"));
  EXPECT_TRUE(holds(with("friction=\"0.6\"", "").yaml, "friction: 1   # of the feet"));
  EXPECT_TRUE(holds(with("friction=\"0.6\" priority=\"1\"", "").yaml, "friction: 0.6   # of the"));
  EXPECT_TRUE(holds(with("friction=\"0.6\" condim=\"1\"", "condim=\"1\"").missing.at(0),
                    "friction: 0.8, rubber on a dry floor, is assumed; the file has 'foot'"));
}

TEST(Mjcf, HoldsNoJointOfTheChainThatCarriesTheBase) {
  const std::optional<MjcfRobot> robot = hopper();
  if (!robot) GTEST_SKIP() << "no MuJoCo";
  ProposeOptions options;
  options.hold = {"slide_x"};
  EXPECT_TRUE(holds(input_error_of([&] { (void)propose_robot(robot->tree, options); }),
                    "--hold: 'slide_x' is of the chain that carries the base"));
  options.hold = {"knee"};
  EXPECT_NO_THROW((void)propose_robot(robot->tree, options));
}

TEST(Mjcf, FrictionIsThatOfDefaultsAndOfPairs) {
  const std::optional<MjcfRobot> usual = hopper();
  if (!usual) GTEST_SKIP() << "no MuJoCo";
  const testing::Folder folder;
  const std::string rubbed =
      testing::replaced(test::kHopperMjcf, "<worldbody>",
                        "<default><geom friction=\".4 .1 .1\"/></default>\n<worldbody>");
  folder.write("hopper.xml", rubbed);
  const Proposal of_defaults = proposed_of(folder.path() / "hopper.xml");
  EXPECT_TRUE(holds(of_defaults.yaml, "friction: 0.4   # of the feet"));

  // a wall that comes first is no floor
  folder.write("hopper.xml",
               testing::replaced(rubbed, "<geom type=\"plane\"",
                                 "<geom name=\"wall\" type=\"plane\" euler=\"0 1.2 0\" "
                                 "pos=\"-9 0 0\" size=\"5 5 1\" friction=\"0.9 .1 .1\"/>\n"
                                 "<geom type=\"plane\""));
  EXPECT_TRUE(
      holds(proposed_of(folder.path() / "hopper.xml").yaml, "friction: 0.4   # of the feet"));

  // pairs meet whatever the masks say, and files that have them switch these off
  std::string paired = testing::replaced(
      rubbed, "type=\"plane\"", "name=\"floor\" contype=\"0\" conaffinity=\"0\" type=\"plane\"");
  paired =
      testing::replaced(paired, "size=\"0.02\" mass=\"0.5\"",
                        "name=\"toe\" contype=\"0\" conaffinity=\"0\" size=\"0.02\" mass=\"0.5\"");
  paired = testing::replaced(paired, "<actuator>",
                             "<contact><pair geom1=\"toe\" geom2=\"floor\" "
                             "friction=\"0.7 0.7 0 0 0\"/></contact>\n<actuator>");
  folder.write("hopper.xml", paired);
  const Proposal of_pair = proposed_of(folder.path() / "hopper.xml");
  EXPECT_TRUE(holds(of_pair.yaml, "friction: 0.7   # of the feet, by the file: <pair> of 'toe'"));
}

TEST(Mjcf, IsToldFromUrdfByItsFirstElement) {
  const testing::Folder folder;
  folder.write("a",
               "<?xml version=\"1.0\"?>\n<!-- <mujoco> -->\n<robot name=\"r\"><mujoco/></robot>");
  folder.write("b", "<!-- a robot -->\n<mujoco/>");
  EXPECT_FALSE(is_mjcf(folder.path() / "a"));
  EXPECT_TRUE(is_mjcf(folder.path() / "b"));
  EXPECT_FALSE(is_mjcf(folder.path() / "none"));
}

}  // namespace
}  // namespace jaculus::model
