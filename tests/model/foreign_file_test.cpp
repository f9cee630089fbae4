// URDF files as other people write them: what other tools live with is read, each with a note that
// says what was assumed, and refused where strict.

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

// An arm of two links that turn about y.
const char* const kArm =
    R"(<robot name="arm">
<link name="base"/>
<link name="upper"><inertial><origin xyz="0 0 -0.1"/><mass value="2"/>
<inertia ixx="0.02" iyy="0.03" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="lower"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
<inertia ixx="0.02" iyy="0.03" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="30" velocity="5"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
<origin xyz="0 0 -0.3"/><axis xyz="0 1 0"/></joint>
</robot>
)";

SpatialTree edited(const std::string& from, const std::string& to,
                   Reading reading = Reading::lenient) {
  return parse_urdf(testing::replaced(kArm, from, to), "arm.urdf", reading);
}

bool notes(const SpatialTree& tree, const std::string& text) {
  return std::any_of(tree.notes.begin(), tree.notes.end(),
                     [&](const std::string& note) { return note.find(text) != std::string::npos; });
}

/// Reads the edited file, expects the note, and the refusal where strict.
SpatialTree assumed(const std::string& from, const std::string& to, const std::string& note) {
  const SpatialTree tree = edited(from, to);
  EXPECT_TRUE(notes(tree, note)) << note;
  EXPECT_TRUE(notes(tree, "assumed: "));
  EXPECT_TRUE(holds(input_error_of([&] { (void)edited(from, to, Reading::strict); }), "arm.urdf:"));
  return tree;
}

TEST(ForeignFile, TheArmItselfNeedsNoAssumption) {
  const SpatialTree tree = parse_urdf(kArm, "arm.urdf", Reading::strict);
  EXPECT_EQ(tree.joints[0].effort, 30.0);
  EXPECT_EQ(tree.joints[0].velocity, 5.0);
  EXPECT_FALSE(notes(tree, "assumed"));
}

TEST(ForeignFile, DampingAndFrictionAreReadAndWrittenBack) {
  const SpatialTree tree = edited("velocity=\"5\"/>",
                                  "velocity=\"5\"/>\n"
                                  "<dynamics damping=\"0.1\" friction=\"0.2\"/>");
  EXPECT_EQ(tree.joints[0].damping, 0.1);
  EXPECT_EQ(tree.joints[0].friction, 0.2);
  EXPECT_EQ(tree.joints[1].damping, 0.0);
  const SpatialTree again = parse_urdf(write_urdf(tree), "again.urdf", Reading::strict);
  EXPECT_EQ(again.joints[0].damping, 0.1);
  EXPECT_EQ(again.joints[0].friction, 0.2);
}

TEST(ForeignFile, ForeignElementsAreSkippedAndCounted) {
  const SpatialTree tree = assumed("<link name=\"base\"/>",
                                   "<link name=\"base\"><contact><friction value=\"1\"/></contact>"
                                   "<contact/></link>",
                                   "unknown element <contact> in <link>: skipped (2 times");
  EXPECT_EQ(tree.links.size(), 3u);
  (void)assumed("</robot>", "<sensor/></robot>", "unknown element <sensor>: skipped (line 11)");
  (void)assumed("<axis xyz=\"0 1 0\"/><limit", "<axis xyz=\"0 1 0\" rpy=\"0 0 0\"/><limit",
                "<axis>: unknown attribute 'rpy': skipped");
}

TEST(ForeignFile, OfWhatIsGivenTwiceTheFirstCounts) {
  const SpatialTree tree = assumed("<axis xyz=\"0 1 0\"/><limit",
                                   "<axis xyz=\"0 1 0\"/>"
                                   "<axis xyz=\"1 0 0\"/><limit",
                                   "the first counts");
  EXPECT_EQ(tree.joints[0].axis, Vec3::UnitY());
}

TEST(ForeignFile, NumbersThatAreNearlyNumbers) {
  const SpatialTree slip = assumed("lower=\"-1\"", "lower=\"-1.5.\"", "read as '-1.5'");
  EXPECT_EQ(slip.joints[0].range.lower, -1.5);
  const SpatialTree substitution =
      assumed("<origin xyz=\"0 0 -0.3\"/>", "<origin xyz=\"$(optenv ELBOW 0 0.1 -0.4)\"/>",
              "read as '0 0.1 -0.4'");
  EXPECT_EQ(substitution.joints[1].origin, Vec3(0.0, 0.1, -0.4));
  const SpatialTree longer =
      assumed("<origin xyz=\"0 0 -0.3\"/>", "<origin xyz=\"0 0 -0.3\" rpy=\"0 0 0 0\"/>",
              "read as '0 0 0'");
  EXPECT_EQ(longer.joints[1].origin.z(), -0.3);
  // no slip of a dot
  for (const char* bad : {"2 kg", "0x2", "nan", "two", ""})
    EXPECT_TRUE(holds(input_error_of([&] {
                        (void)edited("<mass value=\"2\"/>",
                                     std::string("<mass value=\"") + bad + "\"/>");
                      }),
                      "allowed: 1 finite number"));
}

TEST(ForeignFile, BytesOfZeroAfterTheEnd) {
  const std::string padded = std::string(kArm) + std::string(3, '\0');
  EXPECT_TRUE(notes(parse_urdf(padded, "arm.urdf"), "byte 0x00 found: the end of the file"));
  EXPECT_TRUE(holds(input_error_of([&] { (void)parse_urdf(padded, "arm.urdf", Reading::strict); }),
                    "0x00"));
  std::string within = kArm;
  within[20] = '\0';
  EXPECT_TRUE(holds(input_error_of([&] { (void)parse_urdf(within, "arm.urdf"); }), "0x00"));
}

TEST(ForeignFile, AMassOfZeroIsALinkWithout) {
  const SpatialTree tree =
      assumed("<mass value=\"1\"/>", "<mass value=\"0\"/>", "without mass and inertia");
  EXPECT_EQ(tree.links[2].mass, 0.0);
  EXPECT_EQ(tree.links[2].inertia.norm(), 0.0);
  EXPECT_TRUE(
      holds(input_error_of([] { (void)edited("<mass value=\"1\"/>", "<mass value=\"-1\"/>"); }),
            "mass -1 kg given"));
}

TEST(ForeignFile, AMissingMassOrInertiaIsZero) {
  EXPECT_EQ(
      assumed("<mass value=\"1\"/>", "", "<inertial> has no <mass>: taken as zero").links[2].mass,
      0.0);
}

TEST(ForeignFile, AnInertiaOfZeroIsThatOfASphereOfWater) {
  const SpatialTree tree =
      assumed("<mass value=\"2\"/>\n<inertia ixx=\"0.02\" iyy=\"0.03\" izz=\"0.02\"",
              "<mass value=\"2\"/>\n<inertia ixx=\"0\" iyy=\"0\" izz=\"0\"", "sphere of water");
  // 2 kg of water: r = (3 * 0.002 m^3 / (4 pi))^(1/3) = 78.159 mm, I = 0.4 * 2 * r^2
  EXPECT_NEAR(tree.links[1].inertia(1, 1), 0.4 * 2.0 * 0.0781593 * 0.0781593, 1e-7);
}

TEST(ForeignFile, AnInertiaThatNoBodyHasIsUsedForItsOneMomentInThePlane) {
  const SpatialTree tree =
      assumed("<mass value=\"2\"/>\n<inertia ixx=\"0.02\" iyy=\"0.03\" izz=\"0.02\"",
              "<mass value=\"2\"/>\n<inertia ixx=\"0.02\" iyy=\"0.09\" izz=\"0.02\"",
              "used as it is, for the plane takes one moment of it");
  EXPECT_DOUBLE_EQ(tree.links[1].inertia(1, 1), 0.09);
}

TEST(ForeignFile, MissingLimitsAreNoLimits) {
  const SpatialTree none =
      assumed("<limit lower=\"-1\" upper=\"2\" effort=\"30\" velocity=\"5\"/>", "", "no range");
  EXPECT_TRUE(std::isinf(none.joints[0].range.lower));
  EXPECT_TRUE(std::isinf(none.joints[0].effort));
  EXPECT_EQ(none.joints[0].kind, SpatialJointKind::revolute);

  const SpatialTree effort = assumed(" effort=\"30\"", "", "'effort' is missing: no limit");
  EXPECT_TRUE(std::isinf(effort.joints[0].effort));
  EXPECT_EQ(effort.joints[0].range.upper, 2.0);

  const SpatialTree crossed = assumed("upper=\"2\"", "upper=\"-2\"", "no range");
  EXPECT_TRUE(std::isinf(crossed.joints[0].range.upper));
}

TEST(ForeignFile, AMissingAxisIsUrdfsDefault) {
  EXPECT_EQ(assumed("<axis xyz=\"0 1 0\"/><limit", "<limit", "(1, 0, 0)").joints[0].axis,
            Vec3::UnitX());
}

TEST(ForeignFile, JointsInSpaceAreFixed) {
  const SpatialTree tree =
      assumed("name=\"elbow\" type=\"continuous\"", "name=\"elbow\" type=\"floating\"",
              "type 'floating' given: taken as fixed");
  EXPECT_EQ(tree.joints[1].kind, SpatialJointKind::fixed);
}

TEST(ForeignFile, ANamelessRobotIsCalledAsItsFile) {
  EXPECT_EQ(assumed("<robot name=\"arm\">", "<robot>", "called 'arm'").name, "arm");
}

/// The robot in a folder, with robot.yaml as given.
Robot robot_of(const std::string& urdf, const std::string& yaml,
               Reading reading = Reading::lenient) {
  const testing::Folder folder;
  folder.write("robot.urdf", urdf);
  folder.write("robot.yaml", "format: jaculus-robot/1\nbase: fixed\n" + yaml);
  return read_robot(folder.path(), {}, reading);
}

bool notes(const Robot& robot, const std::string& text) {
  return std::any_of(robot.notes.begin(), robot.notes.end(),
                     [&](const std::string& note) { return note.find(text) != std::string::npos; });
}

TEST(ForeignFile, WhatHasNoMassAndCarriesNoneIsHeld) {
  const std::string dummy = testing::replaced(
      kArm, "</robot>",
      "<link name=\"camera\"/><joint name=\"pan\" type=\"continuous\"><parent link=\"lower\"/>"
      "<child link=\"camera\"/><axis xyz=\"0 0 1\"/></joint></robot>");
  const Robot robot = robot_of(dummy, "");
  EXPECT_EQ(robot.planar.size(), 2);
  EXPECT_TRUE(notes(robot, "joint 'pan' is held at zero"));
  EXPECT_TRUE(holds(input_error_of([&] { (void)robot_of(dummy, "", Reading::strict); }),
                    "link 'camera' moves but has no mass"));
}

TEST(ForeignFile, ALinkWithoutMassBetweenTwoJointsWeighsNextToNothing) {
  const std::string text = testing::replaced(kArm, "<mass value=\"2\"/>", "<mass value=\"0\"/>");
  const Robot robot = robot_of(text, "");
  EXPECT_DOUBLE_EQ(robot.planar.bodies[1].mass, 1e-8);
  EXPECT_EQ(robot.planar.size(), 2);
  EXPECT_TRUE(notes(robot, "link 'upper' moves but has no mass: a 1e-8th"));
}

TEST(ForeignFile, AxesThatLeanALittleAreTakenAsInThePlane) {
  const auto leaning = [](double roll) {
    return testing::replaced(kArm, "<origin xyz=\"0 0 -0.3\"/>",
                             "<origin xyz=\"0 0 -0.3\" rpy=\"" + std::to_string(roll) + " 0 0\"/>");
  };
  const Robot robot = robot_of(leaning(0.1), "");
  EXPECT_TRUE(notes(robot, "leans by 5.73 deg"));
  // at this pose nothing is lost: 0.2 m along the leaning link and its moment about y
  EXPECT_NEAR(robot.planar.bodies[2].com.y(), -0.2 * std::cos(0.1), 1e-12);
  EXPECT_NEAR(robot.planar.bodies[2].inertia,
              0.03 * std::cos(0.1) * std::cos(0.1) + 0.02 * std::sin(0.1) * std::sin(0.1), 1e-12);
  EXPECT_TRUE(
      holds(input_error_of([&] { (void)robot_of(leaning(0.1), "", Reading::strict); }), "axis ("));
  EXPECT_TRUE(holds(input_error_of([&] { (void)robot_of(leaning(0.2), ""); }), "fixed_joints"));
}

TEST(ForeignFile, AFrameThatIsTurnedStandsForTheRobotsAxes) {
  // the elbow's z axis lies across, as in files of CAD programs
  const std::string text = testing::replaced(
      testing::replaced(kArm, "<origin xyz=\"0 0 -0.3\"/><axis xyz=\"0 1 0\"/>",
                        "<origin xyz=\"0 0 -0.3\" rpy=\"-1.5707963267948966 0 0\"/>"
                        "<axis xyz=\"0 0 1\"/>"),
      "<origin xyz=\"0 0 -0.2\"/>", "<origin xyz=\"0 0.2 0\"/>");
  const Robot robot = robot_of(text, "points: {tip: {link: lower, point: [0.01, -0.4]}}\n");
  const Robot plain = robot_of(kArm, "points: {tip: {link: lower, point: [0.01, -0.4]}}\n");
  EXPECT_TRUE(notes(robot, "frames of 1 moving link is turned"));
  EXPECT_NEAR((robot.planar.bodies[2].com - plain.planar.bodies[2].com).norm(), 0.0, 1e-12);
  EXPECT_NEAR((robot.planar.points[0].position - plain.planar.points[0].position).norm(), 0.0,
              1e-12);
  EXPECT_EQ(robot.planar.bodies[2].sign, 1.0);
}

TEST(ForeignFile, AxesSayHowTheFileLies) {
  // y up, z forward: x points to the left, and the arm hangs along -y
  std::string text = kArm;
  for (const char* z : {"0 0 -0.1", "0 0 -0.2", "0 0 -0.3"})
    text = testing::replaced(text, z, "0 " + std::string(z).substr(4) + " 0");
  for (int i = 0; i < 2; ++i)
    text = testing::replaced(text, "<axis xyz=\"0 1 0\"/>", "<axis xyz=\"1 0 0\"/>");
  for (int i = 0; i < 2; ++i)
    text = testing::replaced(text, "ixx=\"0.02\" iyy=\"0.03\"", "ixx=\"0.03\" iyy=\"0.02\"");
  const Robot robot = robot_of(text, "axes: {forward: +z, up: +y}\n");
  const Robot plain = robot_of(kArm, "");
  for (std::size_t b = 1; b < 3; ++b) {
    EXPECT_NEAR((robot.planar.bodies[b].com - plain.planar.bodies[b].com).norm(), 0.0, 1e-15);
    EXPECT_NEAR(robot.planar.bodies[b].inertia, 0.03, 1e-15);
    EXPECT_EQ(robot.planar.bodies[b].sign, 1.0);
  }
  EXPECT_TRUE(holds(input_error_of([&] { (void)robot_of(text, "axes: {forward: +z, up: -z}\n"); }),
                    "axes: forward and up lie on one line"));
}

TEST(ForeignFile, TheBaseLinkBeginsTheRobot) {
  const Robot robot = robot_of(kArm, "base_link: upper\n");
  EXPECT_EQ(robot.planar.bodies[0].name, "upper");
  EXPECT_EQ(robot.planar.size(), 1);
  EXPECT_TRUE(holds(input_error_of([] { (void)robot_of(kArm, "base_link: uper\n"); }),
                    "did you mean 'upper'"));
}

TEST(ForeignFile, AnIdealMotorMayHaveARotor) {
  const Robot robot =
      robot_of(kArm, "motors: {elbow: {kind: ideal, torque_limit: 3, rotor_inertia: 0.01}}\n");
  EXPECT_EQ(robot.planar.motors[0].rotor_inertia, 0.01);
}

// Two arms side by side; the right one's axis points the other way.
std::string two_arms(const std::string& right_axis, const std::string& right_mass,
                     const std::string& right_limit, const std::string& right_x) {
  const auto arm = [](const std::string& side, const std::string& y, const std::string& axis,
                      const std::string& mass, const std::string& limit, const std::string& x) {
    return "<link name=\"" + side + "\"><inertial><origin xyz=\"0 0 -0.1\"/><mass value=\"" + mass +
           "\"/><inertia ixx=\"0.02\" iyy=\"0.03\" izz=\"0.02\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>"
           "</inertial></link><joint name=\"j_" +
           side +
           "\" type=\"revolute\"><parent link=\"base\"/>"
           "<child link=\"" +
           side + "\"/><origin xyz=\"" + x + " " + y + " 0\"/><axis xyz=\"0 " + axis +
           " 0\"/><limit " + limit + " effort=\"1\" velocity=\"1\"/></joint>\n";
  };
  return "<robot name=\"two\"><link name=\"base\"/>\n" +
         arm("left", "0.1", "1", "1", "lower=\"-1\" upper=\"2\"", "0") +
         arm("right", "-0.1", right_axis, right_mass, right_limit, right_x) + "</robot>\n";
}

const char* const kPair = "pairs: {joints: {both: [j_left, j_right]}}\n";

TEST(ForeignFile, OfAPairThatTurnsOppositeWaysTheLeftOneCounts) {
  const Robot robot = robot_of(two_arms("-1", "1", "lower=\"-2\" upper=\"0.5\"", "0"), kPair);
  EXPECT_EQ(robot.planar.bodies[1].sign, 1.0);
  EXPECT_EQ(robot.planar.bodies[1].count, 2);
  // minus the right one's -2 to 0.5, within the left one's -1 to 2
  EXPECT_EQ(robot.planar.coordinates[0].range.lower, -0.5);
  EXPECT_EQ(robot.planar.coordinates[0].range.upper, 2.0);
  EXPECT_TRUE(notes(robot, "'j_right' turns the other way"));
}

TEST(ForeignFile, SidesThatWeighDifferentlyAreAddedExactly) {
  const std::string text = testing::replaced(two_arms("1", "3", "lower=\"-1\" upper=\"2\"", "0"),
                                             "<origin xyz=\"0 0 -0.1\"/><mass value=\"3\"/>",
                                             "<origin xyz=\"0 0 -0.3\"/><mass value=\"3\"/>");
  const Robot robot = robot_of(text, kPair);
  const PlanarBody& body = robot.planar.bodies[1];
  EXPECT_DOUBLE_EQ(body.mass, 4.0);
  EXPECT_DOUBLE_EQ(body.com.y(), -(1 * 0.1 + 3 * 0.3) / 4.0);
  // about the common centre, 0.25 m down: 0.03 twice, 1 kg at 0.15 m, 3 kg at 0.05 m
  EXPECT_DOUBLE_EQ(body.inertia, 0.06 + 1 * 0.15 * 0.15 + 3 * 0.05 * 0.05);
  EXPECT_TRUE(notes(robot, "differ in mass: 1 and 3 kg: added as they are"));
}

TEST(ForeignFile, SidesWhoseFramesAreTurnedAgainstOneAnotherAreAddedExactly) {
  // the same robot, the right link's frame turned about y by half a turn
  const std::string limits = "lower=\"-1\" upper=\"2\"";
  const std::string plain = two_arms("1", "1", limits, "0");
  std::string turned =
      testing::replaced(plain, "<origin xyz=\"0 -0.1 0\"/>",
                        "<origin xyz=\"0 -0.1 0\" rpy=\"0 3.141592653589793 0\"/>");
  const std::size_t right = turned.find("<link name=\"right\"");
  turned.replace(turned.find("0 0 -0.1", right), 8, "0 0 0.1");
  const PlanarBody a = robot_of(plain, kPair).planar.bodies[1];
  const PlanarBody b = robot_of(turned, kPair).planar.bodies[1];
  EXPECT_NEAR((a.com - b.com).norm(), 0.0, 1e-15);
  EXPECT_NEAR(a.inertia, b.inertia, 1e-15);
  EXPECT_TRUE(notes(robot_of(turned, kPair), "left against right"));
}

TEST(ForeignFile, SidesMayBeApartByABuildersTolerance) {
  const std::string limits = "lower=\"-1\" upper=\"2\"";
  EXPECT_TRUE(notes(robot_of(two_arms("1", "1", limits, "0.001"), kPair),
                    "differ in joint position x: 0 and 0.001 m: the left one's"));
  EXPECT_TRUE(
      holds(input_error_of([&] { (void)robot_of(two_arms("1", "1", limits, "0.003"), kPair); }),
            "differ in joint position x"));
}

}  // namespace
}  // namespace jaculus::model
