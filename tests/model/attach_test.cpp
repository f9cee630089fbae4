// What robot.yaml attaches: the composed robot against closed forms, the one switch, and faults.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "jaculus/model/mjcf.h"
#include "jaculus/model/robot.h"
#include "model/support.h"
#include "support/input_error.h"

namespace jaculus::model {
namespace {

using test::holds;
using test::input_error_of;
using testing::Folder;

// A trunk on one leg; its frame lies with y up and z forward where `turned`.
const char* const kHopperUrdf =
    R"(<robot name="hopper">
<link name="trunk"><inertial><origin xyz="0.1 0 0.05"/><mass value="6"/>
<inertia ixx="0.02" iyy="0.08" izz="0.09" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="leg"><inertial><origin xyz="0 0 -0.1"/><mass value="1"/>
<inertia ixx="0.02" iyy="0.03" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hip" type="revolute"><parent link="trunk"/><child link="leg"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="30" velocity="5"/></joint>
</robot>
)";

const char* const kHopperYaml = R"(format: jaculus-robot/1
base: floating
friction: 0.8
feet:
  foot: {link: leg, point: [0, -0.3]}
motors:
  hip: {kind: ideal, torque_limit: 30 N m, speed_limit: 5 rad/s}
attach:
  tail:
    to: trunk
    at: [-0.2 m, 0.03 m]
    length: 1 m
    scoop: 0.4 m
    width: 0.2 m
    mass: 10 %
    motor: hip
    gear: 2
)";

Robot robot_with(const std::string& from = "", const std::string& to = "",
                 const std::vector<std::pair<std::string, std::string>>& overrides = {}) {
  const Folder folder;
  folder.write("robot.urdf", kHopperUrdf);
  folder.write("robot.yaml", from.empty() ? kHopperYaml : testing::replaced(kHopperYaml, from, to));
  std::vector<Override> list;
  for (const auto& [path, value] : overrides) {
    const yaml::Node node = yaml::Node::parse("{\"" + path + "\": " + value + "}", "problem.yaml");
    list.push_back({path, node.at(path)});
  }
  return read_robot(folder.path(), list);
}

std::string fault(const std::string& from, const std::string& to,
                  const std::vector<std::pair<std::string, std::string>>& overrides = {}) {
  return input_error_of([&] { (void)robot_with(from, to, overrides); });
}

const PlanarBody& tail_of(const Robot& robot) {
  return robot.planar.bodies.at(robot.planar.body_of_joint("tail"));
}

TEST(Attach, AUniformTailHasTheMassAndInertiaOfARod) {
  const Robot robot = robot_with();
  const PlanarBody& tail = tail_of(robot);
  EXPECT_NEAR(tail.mass, 0.7, 1e-12);  // a tenth of 7 kg
  EXPECT_LT((tail.origin - Vec2(-0.2, 0.03)).norm(), 1e-12);
  EXPECT_LT((tail.com - Vec2(0.0, 0.5)).norm(), 1e-12);
  EXPECT_NEAR(tail.inertia, 0.7 / 12.0, 1e-12);
  EXPECT_NEAR(robot.planar.total_mass(), 7.7, 1e-12);
}

TEST(Attach, AHeavyScoopMovesTheCentreOfMassOutwards) {
  // 0.3 kg over 0.6 m, then 0.4 kg over 0.4 m: moments about the pivot by Steiner
  const PlanarBody tail = tail_of(robot_with("mass: 10 %", "mass: 0.7 kg\n    scoop_mass: 0.4 kg"));
  const double c = (0.3 * 0.3 + 0.4 * 0.8) / 0.7;
  const double about_pivot = 0.3 * 0.36 / 3.0 + 0.4 * (1.0 - 0.216) / (3.0 * 0.4);
  EXPECT_NEAR(tail.com.y(), c, 1e-12);
  EXPECT_NEAR(tail.inertia, about_pivot - 0.7 * c * c, 1e-12);
}

TEST(Attach, TwoOfLengthShaftAndScoopAreEnough) {
  for (const char* keys : {"length: 1 m\n    shaft: 0.6 m", "shaft: 0.6 m\n    scoop: 0.4 m",
                           "length: 1 m\n    shaft: 0.6 m\n    scoop: 0.4 m"}) {
    const Robot robot = robot_with("length: 1 m\n    scoop: 0.4 m", keys);
    const PlanarDrag& drag = robot.planar.drags.at(0);
    EXPECT_NEAR(drag.start, 0.6, 1e-12) << keys;
    EXPECT_NEAR(drag.end, 1.0, 1e-12) << keys;
  }
}

TEST(Attach, ATailBringsDragMotorRangeAndTip) {
  const PlanarModel model = robot_with().planar;
  ASSERT_EQ(model.drags.size(), 1u);
  EXPECT_EQ(model.drags[0].name, "tail");
  EXPECT_EQ(model.drags[0].coefficient, 2.0);
  EXPECT_EQ(model.drags[0].width, 0.2);
  EXPECT_NEAR(model.drags[0].point_area, 0.08, 1e-12);

  const PlanarMotor& motor = model.motors.at(model.motor_index("tail"));
  EXPECT_EQ(motor.torque_limit, 30.0);
  EXPECT_EQ(motor.speed_limit, 5.0);
  EXPECT_EQ(motor.gear, 2.0);
  EXPECT_EQ(motor.count, 1);
  EXPECT_EQ(motor.body, model.body_of_joint("tail"));

  const Coordinate& c = model.coordinates.at(model.coordinate_index("tail"));
  EXPECT_NEAR(c.range.lower, -M_PI / 2.0, 1e-12);
  ASSERT_EQ(model.points.size(), 1u);
  EXPECT_EQ(model.points[0].name, "tail_tip");
  EXPECT_LT((model.points[0].position - Vec2(0.0, 1.0)).norm(), 1e-12);
}

TEST(Attach, OneSwitchTakesTheAirOrTheTailAway) {
  for (const bool by_override : {false, true}) {
    const auto of = [&](const std::string& kind) {
      return by_override ? robot_with("", "", {{"attach.tail.kind", kind}}).planar
                         : robot_with("length: 1 m", "kind: " + kind + "\n    length: 1 m").planar;
    };
    EXPECT_EQ(of("drag").drags.size(), 1u);
    const PlanarModel inertial = of("inertial");
    EXPECT_EQ(inertial.drags.at(0).kind, DragKind::none);
    EXPECT_NEAR(inertial.total_mass(), 7.7, 1e-12);
    const PlanarModel none = of("none");
    EXPECT_EQ(none.body_of_joint("tail"), -1);
    EXPECT_EQ(none.motors.size(), 1u);
    EXPECT_NEAR(none.total_mass(), 7.0, 1e-12);
  }
}

TEST(Attach, OverridesReplaceAnyOfItsKeys) {
  const Robot robot = robot_with("", "",
                                 {{"attach.tail.mass", "1.4 kg"},
                                  {"attach.tail.gear", "3"},
                                  {"tail.drag.coefficient", "1.2"}});
  EXPECT_NEAR(tail_of(robot).mass, 1.4, 1e-12);
  EXPECT_EQ(robot.planar.motors.back().gear, 3.0);
  EXPECT_EQ(robot.planar.drags[0].coefficient, 1.2);
  EXPECT_TRUE(holds(fault("", "", {{"attach.tail.lenght", "1"}}),
                    "problem.yaml:1: attach.tail.lenght: unknown key of what is attached "
                    "'attach.tail.lenght', did you mean 'attach.tail.length'?"));
}

TEST(Attach, ItStandsUprightOnALinkWhoseAxesLieOtherwise) {
  // the same trunk with y up and z forward
  const Folder folder;
  std::string urdf = testing::replaced(kHopperUrdf, "xyz=\"0.1 0 0.05\"", "xyz=\"0 0.05 0.1\"");
  urdf = testing::replaced(urdf, "ixx=\"0.02\" iyy=\"0.08\" izz=\"0.09\"",
                           "ixx=\"0.08\" iyy=\"0.09\" izz=\"0.02\"");
  urdf = testing::replaced(urdf, "<axis xyz=\"0 1 0\"/>", "<axis xyz=\"1 0 0\"/>");
  urdf = testing::replaced(urdf, "xyz=\"0 0 -0.1\"", "xyz=\"0 -0.1 0\"");
  urdf = testing::replaced(urdf, "ixx=\"0.02\" iyy=\"0.03\"", "ixx=\"0.03\" iyy=\"0.02\"");
  folder.write("robot.urdf", urdf);
  folder.write("robot.yaml",
               testing::replaced(testing::replaced(kHopperYaml, "base: floating",
                                                   "axes: {forward: +z, up: +y}\nbase: floating"),
                                 "feet:\n  foot: {link: leg, point: [0, -0.3]}\n", ""));
  const Robot robot = read_robot(folder.path());
  const PlanarBody& tail = tail_of(robot);
  EXPECT_LT((tail.origin - Vec2(-0.2, 0.03)).norm(), 1e-12);
  EXPECT_NEAR(tail.angle_offset, 0.0, 1e-12);
  EXPECT_EQ(tail.sign, 1.0);
  EXPECT_LT((tail.com - Vec2(0.0, 0.5)).norm(), 1e-12);
}

TEST(Attach, TheTreeInSpaceHasItToo) {
  const Folder folder;
  folder.write("robot.urdf", kHopperUrdf);
  folder.write("robot.yaml", kHopperYaml);
  const SpatialTree tree = read_tree(folder.path());
  // written out and read again it is the robot that robot.yaml composes
  const Folder whole;
  whole.write("robot.urdf", write_urdf(tree));
  const SpatialTree again = read_urdf(whole.path() / "robot.urdf", Reading::strict);
  const SpatialLink& tail = again.links.at(again.link_index("tail"));
  EXPECT_NEAR(tail.mass, 0.7, 1e-12);
  EXPECT_NEAR(tail.inertia(1, 1), 0.7 / 12.0, 1e-12);
  EXPECT_LT((tail.p_BL - Vec3(-0.2, 0.0, 0.03)).norm(), 1e-12);
}

TEST(Attach, ASecondUrdfIsFixedAtThePivot) {
  const Folder folder;
  folder.write("robot.urdf", kHopperUrdf);
  folder.write("whip.urdf",
               R"(<robot name="whip"><link name="mount"/>
<link name="whip"><inertial><origin xyz="0 0 0.2"/><mass value="0.5"/>
<inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="root" type="continuous"><parent link="mount"/><child link="whip"/>
<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/></joint></robot>)");
  std::string yaml = kHopperYaml;
  yaml.resize(yaml.find("attach:"));
  folder.write("robot.yaml",
               yaml + "attach:\n  back: {to: trunk, at: [-0.2, 0.03], urdf: whip.urdf}\n");
  const PlanarModel model = read_robot(folder.path()).planar;
  const PlanarBody& whip = model.bodies.at(model.body_of_joint("root"));
  EXPECT_LT((whip.origin - Vec2(-0.2, 0.13)).norm(), 1e-12);
  EXPECT_NEAR(model.total_mass(), 7.5, 1e-12);
}

TEST(Attach, ASecondUrdfOfKindNoneTakesItsMotorsAlong) {
  const Folder folder;
  folder.write("robot.urdf", kHopperUrdf);
  folder.write("whip.urdf",
               R"(<robot name="whip"><link name="mount"/>
<link name="whip"><inertial><origin xyz="0 0 0.2"/><mass value="0.5"/>
<inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="root" type="continuous"><parent link="mount"/><child link="whip"/>
<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/></joint></robot>)");
  std::string yaml = testing::replaced(kHopperYaml, "motors:\n",
                                       "rest_pose: {root: 0.1}\nranges: {root: [-1, 1]}\n"
                                       "points: {lash: {link: whip, point: [0, 0.4]}}\n"
                                       "motors:\n  root: {kind: ideal, torque_limit: 2 N m}\n");
  yaml.resize(yaml.find("attach:"));
  folder.write("robot.yaml",
               yaml + "attach:\n  back: {to: trunk, at: [-0.2, 0.03], urdf: whip.urdf}\n");
  EXPECT_EQ(read_robot(folder.path()).planar.motors.size(), 2u);
  const yaml::Node none = yaml::Node::parse("{kind: none}", "problem.yaml");
  const Robot without = read_robot(folder.path(), {{"attach.back.kind", none.at("kind")}});
  EXPECT_EQ(without.planar.motors.size(), 1u);
  EXPECT_TRUE(without.planar.points.empty());
  EXPECT_NEAR(without.planar.total_mass(), 7.0, 1e-12);
}

TEST(Attach, JointsInSpaceSayThatTheFileDoesNotHaveThem) {
  const PlanarModel model = robot_with().planar;
  const auto joint = [&](const char* name) {
    return model.bodies.at(model.body_of_joint(name)).file_joints.at(0);
  };
  EXPECT_TRUE(joint("tail").attached);
  EXPECT_FALSE(joint("hip").attached);
}

TEST(Attach, TheTreeBeginsAtTheBaseLinkAndShowsTheTail) {
  const Folder folder;
  folder.write("robot.urdf", testing::replaced(kHopperUrdf, "</robot>", R"(<link name="rail"/>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="trunk"/><origin xyz="0 0 1"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="2" effort="30" velocity="5"/></joint></robot>)"));
  folder.write("robot.yaml", testing::replaced(kHopperYaml, "base: floating",
                                               "base_link: trunk\nbase: floating"));
  const SpatialTree tree = read_tree(folder.path());
  EXPECT_EQ(tree.links.at(tree.root).name, "trunk");
  EXPECT_EQ(tree.joint_index("slide"), -1);
  EXPECT_NEAR(tree.total_mass(), 7.7, 1e-12);
  const SpatialLink& tail = tree.links.at(tree.link_index("tail"));
  EXPECT_LT((tail.p_BL - Vec3(-0.2, 0.0, 0.03)).norm(), 1e-12);
  ASSERT_EQ(tail.shapes.size(), 2u);
  EXPECT_FALSE(tail.shapes[0].touches);
  EXPECT_TRUE(holds(write_urdf(tree), "<visual><origin xyz=\"0 0 0.8\""));
}

TEST(Attach, FaultsNameFileLineAndWhatIsAllowed) {
  EXPECT_TRUE(holds(fault("to: trunk", "to: trunc"),
                    "robot.yaml:10: attach.tail.to: unknown link 'trunc', did you mean 'trunk'?"));
  EXPECT_TRUE(holds(fault("motor: hip", "motor: hop"), "unknown joint with a motor 'hop'"));
  EXPECT_TRUE(holds(fault("mass: 10 %", "mass: 10 N"), "attach.tail.mass: '10 N' is in N"));
  EXPECT_TRUE(holds(fault("    mass: 10 %\n", ""), "attach.tail: key 'mass' is missing"));
  EXPECT_TRUE(holds(fault("    width: 0.2 m\n", ""), "attach.tail: key 'width' is missing"));
  EXPECT_TRUE(
      holds(fault("    scoop: 0.4 m\n", ""), "length alone doesn't say where the air acts"));
  EXPECT_TRUE(
      holds(fault("scoop: 0.4 m", "scoop: 1.4 m"),
            "attach.tail.scoop: 1.4 m given on a tail of 1 m; allowed: at most its length"));
  EXPECT_TRUE(holds(fault("scoop: 0.4 m", "scoop: 0.4 m\n    shaft: 0.7 m"),
                    "shaft and scoop are 1.1 m together"));
  // told where it came about
  EXPECT_TRUE(holds(fault("", "", {{"attach.tail.scoop", "1.4 m"}}),
                    "problem.yaml:1: attach.tail.scoop: 1.4 m given on a tail of 1 m"));
  EXPECT_TRUE(holds(fault("", "", {{"attach.tail.length", "0.3 m"}}),
                    "problem.yaml:1: attach.tail.length: 0.3 m given with a scoop of 0.4 m"));
  EXPECT_TRUE(holds(
      fault("", "", {{"attach.tail.shaft", "0.7 m"}}),
      "problem.yaml:1: attach.tail.shaft: length is 1 m, but shaft and scoop are 1.1 m together"));
  EXPECT_TRUE(holds(fault("length: 1 m", "kind: wing\n    length: 1 m"),
                    "'wing' given; allowed: none, inertial, drag"));
  EXPECT_TRUE(holds(fault("length: 1 m", "colour: red\n    length: 1 m"), "unknown key 'colour'"));
  EXPECT_TRUE(
      holds(fault("  tail:\n", "  leg:\n"), "'leg' is a link or joint of the robot already"));
  EXPECT_TRUE(holds(fault("  hip: {", "  tail: {kind: ideal}\n  hip: {"),
                    "'tail' is in motors as well; allowed: in one of the two"));
}

}  // namespace
}  // namespace jaculus::model
