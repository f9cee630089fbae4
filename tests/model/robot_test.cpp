#include "jaculus/model/robot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "jaculus/model/urdf.h"
#include "model/support.h"

namespace jaculus::model {
namespace {

namespace fs = std::filesystem;
using testing::kModels;

Override set(const std::string& path, const std::string& value) {
  const yaml::Node node = yaml::Node::parse("override: {" + path + ": " + value + "}", "p.yaml");
  return {path, node.at("override").at(path)};
}

bool mentions(const std::vector<std::string>& lines, const std::string& text) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& s) { return s.find(text) != std::string::npos; });
}

TEST(Robot, EveryModelReadsAndExplainsItself) {
  int robots = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(kModels)) {
    const Robot robot = read_robot(entry.path());
    EXPECT_EQ(robot.name, entry.path().filename().string());
    EXPECT_EQ(robot.planar.joint_map.rows(), robot.planar.bodies.size());
    EXPECT_EQ(robot.planar.joint_map.cols(), robot.planar.size());
    const char* gravity =
        robot.name == "self_righting" ? "gravity = 0 [m/s^2]" : "gravity = 9.81 [m/s^2]";
    EXPECT_TRUE(mentions(override_paths(entry.path()), gravity)) << robot.name;
    ++robots;
  }
  EXPECT_GE(robots, 6);
}

TEST(Robot, NotesWhatWasMergedAndDropped) {
  const Robot robot = read_robot(kModels / "minitaur_tail");
  EXPECT_TRUE(mentions(robot.notes, "'front_a' stands for 'front_left_a' and 'front_right_a'"));
  EXPECT_TRUE(
      mentions(robot.notes, "'tail_scoop' is fixed by 'tail_scoop_joint' and merged into 'tail'"));
  EXPECT_TRUE(mentions(robot.notes, "sideways positions dropped (links up to 0.125 m"));
}

TEST(Robot, ExplainsEveryKeyOfTheExamples) {
  const std::string text = explain_robot();
  for (const char* key : {"format",
                          "urdf",
                          "base",
                          "gravity",
                          "friction",
                          "pairs",
                          "fixed_joints",
                          "loops",
                          "dependent",
                          "branch",
                          "coordinates",
                          "ranges",
                          "rest_pose",
                          "feet",
                          "points",
                          "motors",
                          "torque_constant",
                          "resistance",
                          "saturation_linear",
                          "saturation_cubic",
                          "voltage",
                          "current_limit",
                          "torque_limit",
                          "gear",
                          "efficiency",
                          "rotor_inertia",
                          "drag",
                          "direction",
                          "density",
                          "coefficient",
                          "width",
                          "start",
                          "end",
                          "point_distance",
                          "point_area",
                          "wind"}) {
    EXPECT_NE(text.find(key), std::string::npos) << key;
  }
}

TEST(Robot, SlidersAndPendulums) {
  const PlanarModel slider = read_robot(kModels / "slider").planar;
  ASSERT_EQ(slider.size(), 1);
  EXPECT_FALSE(slider.coordinates[0].angular);
  EXPECT_EQ(slider.bodies[1].axis, Vec2(1.0, 0.0));
  EXPECT_TRUE(slider.motors[0].ideal());
  EXPECT_EQ(slider.motors[0].torque_limit, 1.0);
  const PlanarModel pendulum = read_robot(kModels / "pendulum").planar;
  EXPECT_EQ(pendulum.coordinates[0].name, "swing");
  EXPECT_EQ(pendulum.bodies[1].com, Vec2(0.0, -1.0));
  const PlanarModel cart_pole = read_robot(kModels / "cart_pole").planar;
  EXPECT_EQ(cart_pole.size(), 2);
  EXPECT_EQ(cart_pole.bodies[2].parent, 1);
}

TEST(Robot, PlainUrdfGetsAFixedBaseAndIdealMotors) {
  const testing::Folder folder;
  folder.write("robot.urdf", testing::read_text(kModels / "ak80_pendulum" / "robot.urdf"));
  const Robot robot = read_robot(folder.path());
  EXPECT_TRUE(mentions(robot.notes, "no robot.yaml"));
  EXPECT_EQ(robot.planar.size(), 1);
  EXPECT_TRUE(robot.planar.motors.at(0).ideal());
}

TEST(Robot, RealPendulumReads) {
  const fs::path data = testing::data_folder();
  if (data.empty()) {
    ASSERT_EQ(std::getenv("CI"), nullptr) << "the real data must be there: set JACULUS_DATA";
    GTEST_SKIP() << "no real data: set JACULUS_DATA or put it in ../shared/data";
  }
  const PlanarModel real = read_robot(data / "pendulum" / "ak80" / "robot").planar;
  const PlanarModel own = read_robot(kModels / "ak80_pendulum").planar;
  EXPECT_EQ(real.bodies[1].mass, own.bodies[1].mass);
  EXPECT_EQ(real.bodies[1].inertia, own.bodies[1].inertia);
  EXPECT_EQ(real.bodies[1].com, own.bodies[1].com);
}

TEST(Robot, TurnedFramesAndHeldJointsKeepTheirPlace) {
  // An arm of two links whose frames are pitched, a joint about x between them that is held, an
  // inertia along tilted axes.
  const testing::Folder folder;
  folder.write("robot.urdf", R"(<robot name="arm">
<link name="ground"/>
<link name="one"><inertial><origin xyz="0.1 0.3 0.2" rpy="0 0.5 0"/><mass value="2"/>
  <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="roll"><inertial><origin xyz="0 0 0"/><mass value="1"/>
  <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="a" type="revolute"><parent link="ground"/><child link="one"/>)"
                             R"(<origin xyz="0 0 1" rpy="0 0.4 0"/><axis xyz="0 -2 0"/>
  <limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
<joint name="b" type="continuous"><parent link="one"/><child link="roll"/><origin xyz="0.5 0 0"/>)"
                             R"(<axis xyz="1 0 0"/></joint>
</robot>)");
  folder.write("robot.yaml", "format: jaculus-robot/1\nbase: fixed\nfixed_joints: {b: 90 deg}\n");
  const PlanarModel m = read_robot(folder.path()).planar;
  ASSERT_EQ(m.bodies.size(), 2u);
  const PlanarBody& one = m.bodies[1];
  EXPECT_EQ(one.sign, -1.0);
  EXPECT_NEAR(one.angle_offset, 0.4, 1e-12);
  EXPECT_EQ(one.origin, Vec2(0.0, 1.0));
  EXPECT_DOUBLE_EQ(one.mass, 3.0);
  const Vec2 com = (2.0 * Vec2(0.1, 0.2) + Vec2(0.5, 0.0)) / 3.0;
  EXPECT_NEAR((one.com - com).norm(), 0.0, 1e-12);
  // The rolled link's z axis has become the one across the plane: its izz counts.
  const double inertia = 0.03 + 2.0 * (Vec2(0.1, 0.2) - com).squaredNorm() + 0.04 +
                         (Vec2(0.5, 0.0) - com).squaredNorm();
  EXPECT_NEAR(one.inertia, inertia, 1e-12);
  // Of mass times distance squared along principal axes: 0.025, 0.015, 0.005; those of the first
  // link are pitched by 0.5, of the rolled one the second lies along z.
  const double c = std::cos(0.5), s = std::sin(0.5);
  const Vec2 own = {0.025 * c * c + 0.005 * s * s + 0.025, 0.025 * s * s + 0.005 * c * c + 0.015};
  const Vec2 squares =
      own + 2.0 * (Vec2(0.1, 0.2) - com).cwiseAbs2() + (Vec2(0.5, 0.0) - com).cwiseAbs2();
  EXPECT_NEAR((one.mass * one.spread.cwiseAbs2() - squares).norm(), 0.0, 1e-12);
  EXPECT_EQ(m.coordinates[0].range.upper, 2.0);
  ASSERT_EQ(m.held.size(), 1u);
  EXPECT_EQ(m.held[0].joint, "b");
  EXPECT_NEAR(m.held[0].value, M_PI / 2, 1e-12);
  ASSERT_EQ(one.file_joints.size(), 1u);
  EXPECT_EQ(one.file_joints[0].name, "a");
}

TEST(Robot, APairKnowsItsJointsInTheFileAndWhichTurnsTheOtherWay) {
  const testing::Folder folder;
  const std::string mass =
      R"(<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>)"
      R"(</inertial>)";
  const auto leg = [](const char* side, const char* y, const char* axis) {
    return std::string("<joint name=\"") + side +
           "_hip\" type=\"continuous\"><parent link=\"body\"/>" + "<child link=\"" + side +
           "_leg\"/><origin xyz=\"0 " + y + " 0\"/><axis xyz=\"0 " + axis + " 0\"/></joint>\n";
  };
  folder.write("robot.urdf", "<robot name=\"two\"><link name=\"body\">" + mass +
                                 "</link>\n<link name=\"l_leg\">" + mass +
                                 "</link>\n<link name=\"r_leg\">" + mass + "</link>\n" +
                                 leg("l", "0.1", "1") + leg("r", "-0.1", "-1") + "</robot>\n");
  folder.write("robot.yaml",
               "format: jaculus-robot/1\nbase: floating\npairs: {joints: {hip: [l_hip, r_hip]}}\n");
  const PlanarModel m = read_robot(folder.path()).planar;
  ASSERT_EQ(m.bodies.size(), 2u);
  ASSERT_EQ(m.bodies[1].file_joints.size(), 2u);
  EXPECT_EQ(m.bodies[1].file_joints[0].name, "l_hip");
  EXPECT_EQ(m.bodies[1].file_joints[0].sign, 1.0);
  EXPECT_EQ(m.bodies[1].file_joints[1].name, "r_hip");
  EXPECT_EQ(m.bodies[1].file_joints[1].sign, -1.0);

  const PlanarModel locked = lock(m, "hip", 0.3);
  ASSERT_EQ(locked.held.size(), 2u);
  EXPECT_EQ(locked.held[0].value, 0.3);
  EXPECT_EQ(locked.held[1].joint, "r_hip");
  EXPECT_EQ(locked.held[1].value, -0.3);
}

TEST(Robot, BranchIsTakenFromTheZeroWhereItIsClosed) {
  // A parallelogram: two cranks of 1 m, 1 m apart, joined over a coupler of 1 m; the coupler and
  // one crank depend.
  const std::string body =
      R"(<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>)"
      R"(</inertial>)";
  std::string urdf = "<robot name=\"four_bar\"><link name=\"ground\"/>\n";
  for (const char* link : {"left", "right", "coupler"})
    urdf += "<link name=\"" + std::string(link) + "\">" + body + "</link>\n";
  const auto joint = [](const std::string& name, const std::string& parent,
                        const std::string& child, const std::string& xyz) {
    return "<joint name=\"" + name + "\" type=\"continuous\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/><origin xyz=\"" + xyz +
           "\"/><axis xyz=\"0 1 0\"/></joint>\n";
  };
  urdf += joint("l", "ground", "left", "0 0 0") + joint("r", "ground", "right", "1 0 0") +
          joint("c", "left", "coupler", "0 0 1");
  const testing::Folder folder;
  folder.write("robot.urdf", urdf + "</robot>");
  folder.write("robot.yaml",
               "format: jaculus-robot/1\nbase: fixed\nloops:\n  bar: {link_a: coupler, point_a: "
               "[1, 0], link_b: right, "
               "point_b: [0, 1], "
               "dependent: [c, r]}\n");
  const PlanarModel m = read_robot(folder.path()).planar;
  ASSERT_EQ(m.loops.size(), 1u);
  // u = (1, 0) - (0, 1), v = (1, 1) - (0, 1): u_z v_x - u_x v_z = -1.
  EXPECT_EQ(m.loops[0].branch, -1.0);
  EXPECT_EQ(m.size(), 1);
  EXPECT_EQ(m.coordinates[0].name, "l");
}

TEST(Robot, OverridesReplaceValues) {
  const PlanarModel m =
      read_robot(
          kModels / "minitaur_tail",
          {set("tail.drag.coefficient", "2.3"), set("tail.drag.kind", "point"),
           set("friction", "0.5"), set("motors.*.resistance", "0.22 ohm"),
           set("motors.tail.resistance", "200 mohm"), set("motors.tail.efficiency", "80 %"),
           set("bodies.base.mass", "7 kg"), set("tail.mass", "0.2"),
           set("ranges.tail", "[-10 deg, 10 deg]"), set("tail.com", "[0, 50 cm]"),
           set("motors.front_a.gear", "=motors.rear_a.gear"), set("motors.rear_a.gear", "2")})
          .planar;
  EXPECT_EQ(m.drags[0].coefficient, 2.3);
  EXPECT_EQ(m.drags[0].kind, DragKind::point);
  EXPECT_EQ(m.friction, 0.5);
  for (const PlanarMotor& motor : m.motors)
    EXPECT_EQ(motor.resistance, motor.joint == "tail" ? 0.2 : 0.22);
  EXPECT_NEAR(m.motors.back().efficiency, 0.8, 1e-15);
  EXPECT_EQ(m.bodies[0].mass, 7.0);
  EXPECT_EQ(m.bodies.back().mass, 0.2);
  EXPECT_EQ(m.bodies.back().com, Vec2(0.0, 0.5));
  EXPECT_NEAR(m.coordinates.back().range.upper, M_PI / 18.0, 1e-15);
  EXPECT_EQ(m.motors[0].gear, 2.0);
}

TEST(Robot, EveryListedPathCanBeOverridden) {
  for (const std::string& line : override_paths(kModels / "minitaur_tail")) {
    const std::string path = line.substr(0, line.find(" = "));
    std::string value = line.substr(line.find(" = ") + 3);
    if (value.ends_with(']') && value.rfind(" [") != std::string::npos)
      value.resize(value.rfind(" ["));
    if (value == "[-inf, inf]") value = "[-.inf, .inf]";
    EXPECT_NO_THROW(read_robot(kModels / "minitaur_tail", {set(path, value)})) << line;
  }
}

TEST(Robot, AMotorIsReplacedAsAWholeAndSingleValuesCountOnTop) {
  const fs::path folder = kModels / "minitaur_tail";
  const PlanarModel m = read_robot(folder, {set("motors.tail", "{kind: ideal, torque_limit: 9}"),
                                            set("motors.tail.torque_limit", "8 N m"),
                                            set("motors.*", "{kind: ideal}")})
                            .planar;
  const PlanarMotor& tail = m.motors[m.motor_index("tail")];
  EXPECT_TRUE(tail.ideal());
  EXPECT_EQ(tail.torque_limit, 8.0);
  EXPECT_EQ(tail.gear, 1.0);
}

TEST(Robot, IsFoundByFolderAndByName) {
  const testing::Folder folder;
  fs::create_directories(folder.path() / "mine");
  folder.write("mine/robot.urdf", testing::read_text(kModels / "pendulum" / "robot.urdf"));
  folder.write("p.yaml", "x: 1\n");
  EXPECT_EQ(find_robot("mine", folder.path() / "p.yaml"), folder.path() / "mine");
  EXPECT_EQ(find_robot("mine", folder.path()), folder.path() / "mine");
  EXPECT_EQ(find_robot((folder.path() / "mine").string(), ""), folder.path() / "mine");
  EXPECT_EQ(find_robot("pendulum", folder.path()), kModels / "pendulum");
  try {
    (void)find_robot("minitour", folder.path());
    ADD_FAILURE();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean 'minitaur'?"), std::string::npos)
        << e.what();
    EXPECT_NE(std::string(e.what()).find("minitaur_tail"), std::string::npos) << e.what();
  }
}

TEST(Lock, HoldsACoordinate) {
  const PlanarModel m = read_robot(kModels / "minitaur_tail").planar;
  const PlanarModel tail = lock(m, "tail", -M_PI / 2);
  EXPECT_EQ(tail.size(), m.size() - 1);
  EXPECT_EQ(tail.coordinate_index("tail"), -1);
  EXPECT_EQ(tail.motor_index("tail"), -1);
  EXPECT_EQ(tail.motors.size(), m.motors.size() - 1);
  EXPECT_EQ(tail.joint_offset[m.body_of_joint("tail")], -M_PI / 2);
  EXPECT_EQ(tail.total_mass(), m.total_mass());

  // A leg's extension alone leaves both of its motors moving.
  const PlanarModel leg = lock(m, "front_extension", 1.2);
  EXPECT_EQ(leg.motors.size(), m.motors.size());
  Vector q(7);
  q << 0, 0, 0, 0.3, 1.0, 0.0, 0.0;
  const Vector theta = leg.joint_map * q + leg.joint_offset;
  EXPECT_DOUBLE_EQ(theta[m.body_of_joint("front_a")], 0.9);
  EXPECT_DOUBLE_EQ(theta[m.body_of_joint("front_b")], 1.5);
  EXPECT_EQ(lock(leg, "front_angle", 0.0).motor_index("front_a"), -1);

  const PlanarModel base = lock(lock(m, "pitch", 0.1), "x", 0.5);
  EXPECT_EQ(base.base_free, (std::array<bool, 3>{false, true, false}));
  EXPECT_EQ(base.base_pose, Eigen::Vector3d(0.5, 0.0, 0.1));
  EXPECT_EQ(base.coordinates[0].name, "z");
}

}  // namespace
}  // namespace jaculus::model
