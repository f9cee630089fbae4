// Bad URDF and robot.yaml files: each is one edit of a good robot, and each message names the
// place, what was given, what is allowed.

#include <gtest/gtest.h>

#include "jaculus/model/robot.h"
#include "jaculus/model/urdf.h"
#include "model/support.h"

namespace jaculus::model {
namespace {

// One element a line, so that the lines below can be counted. Joint b and c carry a crank and a
// coupler that meet rocker d.
const char* const kUrdf =
    R"(<robot name="r">
<link name="base"><inertial><mass value="5"/>)"
    R"(<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="al"><inertial><mass value="1"/>)"
    R"(<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="ar"><inertial><mass value="1"/>)"
    R"(<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="b"><inertial><mass value="2"/>)"
    R"(<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="c"><inertial><mass value="3"/>)"
    R"(<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="d"><inertial><mass value="4"/>)"
    R"(<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j_al" type="continuous"><parent link="base"/><child link="al"/><origin xyz="0 1 0"/>)"
    R"(<axis xyz="0 1 0"/></joint>
<joint name="j_ar" type="continuous"><parent link="base"/><child link="ar"/>)"
    R"(<origin xyz="0 -1 0"/><axis xyz="0 1 0"/></joint>
<joint name="j_b" type="revolute"><parent link="base"/><child link="b"/><axis xyz="0 1 0"/>)"
    R"(<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="j_c" type="continuous"><parent link="b"/><child link="c"/><origin xyz="0 0 1"/>)"
    R"(<axis xyz="0 1 0"/></joint>
<joint name="j_d" type="continuous"><parent link="base"/><child link="d"/><origin xyz="1 0 0"/>)"
    R"(<axis xyz="0 -1 0"/></joint>
</robot>
)";

const char* const kYaml =
    R"(format: jaculus-robot/1
base: floating
friction: 0.8
gravity: 9.81
pairs: {joints: {a: [j_al, j_ar]}, links: {leg: [al, ar]}}
loops: {bar: {link_a: c, point_a: [1, 0], link_b: d, point_b: [0, 1], dependent: [j_c, j_d], )"
    R"(branch: negative}}
coordinates: {sum: {of: {a: 1, j_b: 1}}, difference: {of: {a: 1, j_b: -1}, range: [-1, 1]}}
ranges: {j_c: [-1, 2]}
feet: {toe: {link: leg, point: [0, -1]}}
points: {tip: {link: d, point: [0, 2]}}
motors:
  a: {kind: electric, torque_constant: 0.1, resistance: 0.2, saturation_linear: 9, )"
    R"(saturation_cubic: 0.5, voltage: 16 V, gear: 1, efficiency: 1, rotor_inertia: 0}
  j_b: {kind: ideal, torque_limit: 3}
drag:
  sail: {link: b, direction: [0, 1], kind: distributed, density: 1.2, coefficient: 2, width: 0.2, )"
    R"(start: 0.5, end: 1}
)";

struct Bad {
  bool urdf;  ///< which file is edited
  const char* from;
  const char* to;
  const char* message;  ///< after the folder; the beginning of it where it ends in "..."
};

std::string fault(const Bad& c) {
  const testing::Folder folder;
  folder.write("robot.urdf", c.urdf ? testing::replaced(kUrdf, c.from, c.to) : kUrdf);
  folder.write("robot.yaml", c.urdf ? kYaml : testing::replaced(kYaml, c.from, c.to));
  try {
    (void)read_robot(folder.path(), {}, Reading::strict);
  } catch (const InputError& e) {
    const std::string what = e.what();
    const std::string prefix = folder.path().string() + "/";
    EXPECT_TRUE(what.starts_with(prefix)) << what;
    return what.starts_with(prefix) ? what.substr(prefix.size()) : what;
  }
  return "accepted";
}

void expect_faults(const std::vector<Bad>& cases) {
  for (const Bad& c : cases) {
    std::string expected = c.message;
    std::string given = fault(c);
    if (expected.ends_with("...")) {
      expected.resize(expected.size() - 3);
      given = given.substr(0, expected.size());
    }
    EXPECT_EQ(given, expected) << c.from << " -> " << c.to;
  }
}

TEST(BadRobot, TheRobotItselfIsGood) {
  const testing::Folder folder;
  folder.write("robot.urdf", kUrdf);
  folder.write("robot.yaml", kYaml);
  const PlanarModel m = read_robot(folder.path()).planar;
  EXPECT_EQ(m.size(), 5);
  EXPECT_EQ(m.joint_ranges.size(), 2u);
  EXPECT_EQ(m.bodies.size(), 5u);
}

TEST(BadRobot, Urdf) {
  expect_faults({
      {true, "</robot>", "", "robot.urdf:..."},
      {true, "<robot name=\"r\">", "<robot>",
       "robot.urdf:1: <robot>: attribute 'name' is missing; it must be given"},
      {true, "<robot name=\"r\">", "<model name=\"r\">", "robot.urdf:..."},
      {true, "<link name=\"b\">", "<link name=\"al\">",
       "robot.urdf:5: link 'al' given twice (first in line 3); allowed: once"},
      {true, "name=\"j_c\"", "name=\"j_b\"",
       "robot.urdf:11: joint 'j_b' given twice (first in line 10); allowed: once"},
      {true, "<link name=\"b\">", "<link>",
       "robot.urdf:5: <link>: attribute 'name' is missing; it must be given"},
      {true, "<link name=\"b\">", "<link name=\"\">",
       "robot.urdf:5: <link>: the name is empty; allowed: a word"},
      {true, "<link name=\"b\">", "<lnk name=\"b\"/><link name=\"b\">",
       "robot.urdf:5: unknown element <lnk>, did you mean 'link'?; allowed: link, joint, "
       "material..."},
      {true, "<mass value=\"2\"/>", "<mas value=\"2\"/>",
       "robot.urdf:5: unknown element <mas> in <inertial>, did you mean 'mass'?; allowed: origin, "
       "mass, inertia"},
      {true, "<mass value=\"2\"/>", "",
       "robot.urdf:5: link 'b': <inertial> has no <mass>; it must be given"},
      {true, "<mass value=\"2\"/>", "<mass value=\"2\"/><mass value=\"2\"/>",
       "robot.urdf:5: <mass> given twice in <inertial>; allowed: once"},
      {true, "<mass value=\"2\"/>", "<mass/>",
       "robot.urdf:5: <mass>: attribute 'value' is missing; it must be given"},
      {true, "<mass value=\"2\"/>", "<mass value=\"0\"/>",
       "robot.urdf:5: link 'b': mass 0 kg given; allowed: more than 0"},
      {true, "<mass value=\"2\"/>", "<mass value=\"-2\"/>",
       "robot.urdf:5: link 'b': mass -2 kg given; allowed: more than 0"},
      {true, "<mass value=\"2\"/>", "<mass value=\"nan\"/>",
       "robot.urdf:5: <mass>: value='nan' given; allowed: 1 finite number"},
      {true, "<mass value=\"2\"/>", "<mass value=\"2 kg\"/>",
       "robot.urdf:5: <mass>: value='2 kg' given; allowed: 1 finite number"},
      {true, "<mass value=\"2\"/>", "<mass value=\"1e999\"/>",
       "robot.urdf:5: <mass>: value='1e999' given; ..."},
      {true, "<mass value=\"2\"/><inertia ixx=\"1\"", "<mass value=\"2\"/><inertia ixx=\"0\"",
       "robot.urdf:5: link 'b': inertia with principal moments 0, 1, 1 kg m^2 given; allowed: all "
       "above 0"},
      {true, "<mass value=\"2\"/><inertia ixx=\"1\"", "<mass value=\"2\"/><inertia ixx=\"3\"",
       "robot.urdf:5: link 'b': inertia with principal moments 1, 1, 3 kg m^2 given, which no body "
       "can have; allowed: "
       "the largest at "
       "most the sum of the other two"},
      {true, "<mass value=\"2\"/><inertia ixx=\"1\"", "<mass value=\"2\"/><inertia",
       "robot.urdf:5: <inertia>: attribute 'ixx' is missing; it must be given"},
      {true, "<mass value=\"2\"/><inertia ixx", "<mass value=\"2\"/><inertia ixxx=\"1\" ixx",
       "robot.urdf:5: <inertia>: unknown attribute 'ixxx', did you mean 'ixx'?; allowed: ixx, ixy, "
       "ixz, iyy, iyz, izz"},
      {true, "<origin xyz=\"0 0 1\"/>", "<origin xyz=\"0 1\"/>",
       "robot.urdf:11: <origin>: xyz='0 1' given; allowed: 3 finite numbers"},
      {true, "<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 0 0\"/>",
       "robot.urdf:12: joint 'j_d': axis of length 0 given; allowed: a direction"},
      {true, "<axis xyz=\"0 -1 0\"/>", "",
       "robot.urdf:12: joint 'j_d' has no <axis>; it must be given where a joint moves"},
      {true, "<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"1 0 0\"/>",
       "robot.urdf:12: joint 'j_d': axis (1, 0, 0) in the root's frame given; allowed: +y or -y, "
       "or the joint in "
       "fixed_joints of "
       "robot.yaml"},
      {true, "<origin xyz=\"1 0 0\"/>", "<origin xyz=\"1 0 0\" rpy=\"0.1 0 0\"/>",
       "robot.urdf:12: joint 'j_d': axis (0, -0.995, -0.09983) in the root's frame given; ..."},
      {true, "name=\"j_d\" type=\"continuous\"", "name=\"j_d\" type=\"continous\"",
       "robot.urdf:12: joint 'j_d': type 'continous' given, did you mean 'continuous'?; allowed: "
       "fixed, revolute, "
       "continuous, prismatic"},
      {true, "name=\"j_d\" type=\"continuous\"", "name=\"j_d\" type=\"floating\"",
       "robot.urdf:12: joint 'j_d': type 'floating' given; ..."},
      {true, "name=\"j_d\" type=\"continuous\"", "name=\"j_d\" type=\"prismatic\"",
       "robot.urdf:12: joint 'j_d' (prismatic) needs <limit> with lower, upper, effort and "
       "velocity"},
      {true, "lower=\"-1\"", "lower=\"2\"",
       "robot.urdf:10: joint 'j_b': lower limit 2 is above upper limit 1; allowed: lower <= upper"},
      {true, "<limit lower=\"-1\" upper=\"1\" effort=\"1\"", "<limit lower=\"-1\" upper=\"1\"",
       "robot.urdf:10: <limit>: attribute 'effort' is missing; it must be given"},
      {true, "<parent link=\"b\"/>", "",
       "robot.urdf:11: joint 'j_c' has no <parent>; it must be given"},
      {true, "<parent link=\"b\"/>", "<parent link=\"bb\"/>",
       "robot.urdf:11: joint 'j_c': parent link 'bb' is unknown..."},
      {true, "<child link=\"d\"/>", "<child link=\"c\"/>",
       "robot.urdf:12: link 'c' is the child of both joint 'j_c' and joint 'j_d'; allowed: one "
       "(loops are closed in "
       "robot.yaml)"},
      {true, "<child link=\"d\"/>", "<child link=\"base\"/>",
       "robot.urdf:12: joint 'j_d' connects link 'base' with itself"},
      {true, "<parent link=\"base\"/><child link=\"d\"/>",
       "<parent link=\"c\"/><child link=\"base\"/>",
       "robot.urdf:2: link 'base' is not connected to the root 'd' (its joints form a cycle); "
       "allowed: one tree"},
      {true, "<parent link=\"base\"/><child link=\"b\"/>",
       "<parent link=\"c\"/><child link=\"b\"/>",
       "robot.urdf:5: link 'b' is not connected to the root 'base' (its joints form a cycle); "
       "allowed: one tree"},
      {true, "</robot>", "<link name=\"lost\"/></robot>",
       "robot.urdf:13: links 'base' and 'lost' both have no parent; allowed: one root, all others "
       "connected to it"},
      {true,
       "<link name=\"d\"><inertial><mass value=\"4\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" "
       "ixy=\"0\" ixz=\"0\" "
       "iyz=\"0\"/></inertial></link>",
       "<link name=\"d\"/>",
       "robot.urdf:7: link 'd' moves but has no mass; allowed: <inertial> with a mass above 0"},
      {true, "<axis xyz=\"0 -1 0\"/></joint>",
       "<axis xyz=\"0 -1 0\"/><mimic joint=\"j_b\"/></joint>",
       "robot.urdf:12: unknown element <mimic> in <joint>, did you mean 'limit'?; allowed: origin, "
       "parent, child, "
       "axis, limit, dynamics..."},
  });
}

TEST(BadRobot, Structure) {
  expect_faults({
      {false, "jaculus-robot/1", "jaculus-robot/2",
       "robot.yaml:1: format: 'jaculus-robot/2' given, did you mean..."},
      {false, "gravity: 9.81", "gravty: 9.81",
       "robot.yaml:4: unknown key 'gravty', did you mean 'gravity'?; allowed: format, urdf, ..."},
      {false, "gravity: 9.81", "gravity: 9.81 m/s",
       "robot.yaml:4: gravity: '9.81 m/s' is in m/s; allowed: a number in m/s^2..."},
      {false, "gravity: 9.81", "gravity: -9.81",
       "robot.yaml:4: gravity: -9.81 is out of range; allowed: at least 0 m/s^2"},
      {false, "gravity: 9.81", "urdf: other.urdf",
       "other.urdf: file not found; allowed: a URDF file"},
      {false, "friction: 0.8\n", "", "robot.yaml:1: key 'friction' is missing; it must be given"},
      {false, "friction: 0.8", "friction: -0.1",
       "robot.yaml:3: friction: -0.1 is out of range; allowed: at least 0"},
      {false, "friction: 0.8", "friction: .nan",
       "robot.yaml:3: friction: '.nan' is not a number; ..."},
      {false, "base: floating", "base: flying", "robot.yaml:2: base: 'flying' given..."},
      {false, "base: floating\n", "", "robot.yaml:1: key 'base' is missing; it must be given"},
      {false, "base: floating", "base: {free: [y]}",
       "robot.yaml:2: base.free[0]: 'y' given; allowed: x, z, pitch"},
      {false, "base: floating", "base: {free: [x, x]}",
       "robot.yaml:2: base.free[1]: 'x' given twice; allowed: once"},
      {false, "base: floating", "base: {free: [x], pose: {x: 1}}",
       "robot.yaml:2: base.pose.x: x is free, so it has no fixed value; ..."},
      {false, "base: floating", "base: {free: [x], pose: {y: 1}}",
       "robot.yaml:2: base.pose: unknown key 'y'..."},
      {false, "[j_al, j_ar]", "[j_al, j_arr]",
       "robot.yaml:5: pairs.joints.a[1]: unknown joint 'j_arr', did you mean 'j_ar'?; allowed: "
       "j_al, j_ar, j_b, j_c, "
       "j_d"},
      {false, "[j_al, j_ar]", "[j_al]",
       "robot.yaml:5: pairs.joints.a: 1 names given; allowed: two, [left, right]"},
      {false, "[j_al, j_ar]", "[j_al, j_al]",
       "robot.yaml:5: pairs.joints.a[1]: 'j_al' is in two pairs; allowed: in one"},
      {false, "[j_al, j_ar]", "[j_al, j_b]",
       "robot.urdf:11: joint 'j_c': moves below the right-hand part of a pair; allowed: the right "
       "of a pair"},
      {false, "[j_al, j_ar]", "[j_al, j_c]",
       "robot.yaml:5: pairs.joints.a: 'j_al' and 'j_c' hang on different bodies; ..."},
      {false, "{a: [j_al, j_ar]}", "{j_b: [j_al, j_ar]}",
       "robot.yaml:5: pairs.joints.j_b: 'j_b' is the name of another one in the URDF; allowed: a "
       "new name"},
      {false, "{leg: [al, ar]}", "{leg: [al, b]}",
       "robot.yaml:5: pairs.links.leg: 'al' and 'b' are not in the same place of one planar "
       "body..."},
      {false, "pairs: {joints:", "pairs: {joint:",
       "robot.yaml:5: pairs: unknown key 'joint', did you mean 'joints'?; allowed: joints, links"},
      {false, "[j_al, j_ar]", "[j_b, j_al]",
       "robot.urdf:11: joint 'j_c': moves below the pair 'a' but is in no pair; allowed: ..."},
      {false, "gravity: 9.81", "fixed_joints: {j_x: 0}",
       "robot.yaml:4: fixed_joints.j_x: unknown joint 'j_x', did you mean 'j_b'?; allowed: j_al, "
       "..."},
      {false, "gravity: 9.81", "fixed_joints: {j_al: 0}",
       "robot.yaml:4: fixed_joints.j_al: joint 'j_al' is in the pair 'a'; ..."},
      {false, "gravity: 9.81", "fixed_joints: {j_b: 2}",
       "robot.yaml:4: fixed_joints.j_b: 2 is out of range; allowed: -1 to 1 rad"},
  });
}

TEST(BadRobot, PairsThatDiffer) {
  expect_faults({
      {true, "<link name=\"ar\"><inertial><mass value=\"1\"/>",
       "<link name=\"ar\"><inertial><mass value=\"1.5\"/>",
       "robot.yaml:5: pairs.joints.a: 'j_al' and 'j_ar' differ in mass: 1 and 1.5 kg; allowed: the "
       "same"},
      {true, "<link name=\"ar\"><inertial>",
       "<link name=\"ar\"><inertial><origin xyz=\"0 0 0.1\"/>",
       "robot.yaml:5: pairs.joints.a: 'j_al' and 'j_ar' differ in centre of mass z: 0 and 0.1 m; "
       "allowed: the same"},
      {true, "<origin xyz=\"0 -1 0\"/>", "<origin xyz=\"0.1 -1 0\"/>",
       "robot.yaml:5: pairs.joints.a: 'j_al' and 'j_ar' differ in joint position x: 0 and 0.1 m; "
       "allowed: the same"},
      {true, "<origin xyz=\"0 -1 0\"/>", "<origin xyz=\"0 -1 0\" rpy=\"0 0.1 0\"/>",
       "robot.yaml:5: pairs.joints.a: 'j_al' and 'j_ar' differ in zero angle: 0 and 0.1 rad; "
       "allowed: the same"},
      {true, "<origin xyz=\"0 -1 0\"/><axis xyz=\"0 1 0\"/>",
       "<origin xyz=\"0 -1 0\"/><axis xyz=\"0 -1 0\"/>",
       "robot.yaml:5: pairs.joints.a: 'j_al' and 'j_ar' differ in direction of the axis: 1 and -1; "
       "allowed: the same"},
  });
}

TEST(BadRobot, LoopsAndCoordinates) {
  expect_faults({
      {false, "dependent: [j_c, j_d]", "dependent: [j_c, j_e]",
       "robot.yaml:6: loops.bar.dependent[1]: unknown joint 'j_e', did you mean 'j_b'?; allowed: "
       "a, j_b, j_c, j_d"},
      {false, "dependent: [j_c, j_d]", "dependent: [j_b, j_d]",
       "robot.yaml:6: loops.bar.dependent[0]: joint 'j_b' carries 'b', not 'c'; allowed: 'j_c', "
       "the joint at the root "
       "of link_a"},
      {false, "dependent: [j_c, j_d]", "dependent: [j_c]",
       "robot.yaml:6: loops.bar.dependent: 1 joints given; allowed: two, ..."},
      {false, "link_b: d", "link_b: dd", "robot.yaml:6: loops.bar.link_b: unknown link 'dd'..."},
      {false, "link_b: d, point_b: [0, 1], dependent: [j_c, j_d]",
       "link_b: b, point_b: [0, 1], dependent: [j_c, j_b]",
       "robot.yaml:6: loops.bar: link_a and link_b lie on one branch of the tree; allowed: links "
       "of two branches"},
      {false, "point_b: [0, 1]", "point_b: [0, 0]",
       "robot.yaml:6: loops.bar.point_b: the pin lies on joint 'j_d' itself; ..."},
      {false, "point_b: [0, 1]", "point_b: [0, 1, 2]",
       "robot.yaml:6: loops.bar.point_b: 3 values given; allowed: two, [x, z] in m"},
      {false, "branch: negative", "branch: up",
       "robot.yaml:6: loops.bar.branch: 'up' given; allowed: positive, negative"},
      {false, "point_b: [0, 1], dependent: [j_c, j_d], branch: negative",
       "point_b: [0, 1.1], dependent: [j_c, j_d]",
       "robot.yaml:6: loops.bar: loop 'bar' is open with all joints at zero, so its branch must be "
       "given; ..."},
      {false, "branch: negative}",
       "branch: negative}, again: {link_a: c, point_a: [1, 0], link_b: d, point_b: [0, 1], "
       "dependent: [j_c, j_d]}",
       "robot.yaml:6: loops.again.dependent[0]: joint 'j_c' follows from another loop already; "
       "allowed: once"},
      {false, "sum: {of: {a: 1, j_b: 1}}, ", "",
       "robot.yaml:7: coordinates.difference: 1 coordinate(s) for the 2 joints a, j_b; allowed: as "
       "many coordinates as "
       "joints"},
      {false, "j_b: -1}", "j_b: 1}",
       "robot.yaml:7: coordinates.sum: the coordinates of the joints a, j_b depend on one another; "
       "allowed: "
       "independent combinations"},
      {false, "{a: 1, j_b: 1}", "{a: 1, j_c: 1}",
       "robot.yaml:7: coordinates.sum.of.j_c: joint 'j_c' follows from a loop; ..."},
      {false, "{a: 1, j_b: 1}", "{a: 1, jb: 1}",
       "robot.yaml:7: coordinates.sum.of.jb: unknown joint 'jb', did you mean 'j_b'?..."},
      {false, "{a: 1, j_b: 1}", "{}", "robot.yaml:7: coordinates.sum.of: no joint given; ..."},
      {false,
       "sum:", "x:", "robot.yaml:1: two coordinates are called 'x'; allowed: names that differ"},
      {false, "sum:", "j_b:",
       "robot.yaml:7: coordinates.j_b: 'j_b' is the name of a joint; allowed: a new name"},
      {false, "range: [-1, 1]", "range: [1, -1]",
       "robot.yaml:7: coordinates.difference.range: lower bound 1 is above upper bound -1; "
       "allowed: lower <= upper, in "
       "rad"},
      {false, "ranges: {j_c: [-1, 2]}", "ranges: {j_cc: [-1, 2]}",
       "robot.yaml:8: ranges.j_cc: unknown joint 'j_cc'..."},
      {false, "ranges: {j_c: [-1, 2]}", "ranges: {j_c: [-1 m, 2]}",
       "robot.yaml:8: ranges.j_c[0]: '-1 m' is in m; allowed: a number in rad..."},
  });
}

TEST(BadRobot, PointsMotorsAndDrag) {
  expect_faults({
      {false, "{link: leg, point", "{link: legg, point",
       "robot.yaml:9: feet.toe.link: unknown link 'legg', did you mean 'leg'?..."},
      {false, "point: [0, -1]", "point: [0]",
       "robot.yaml:9: feet.toe.point: 1 values given; allowed: two, [x, z] in m"},
      {false, "tip: {link: d, point", "tip: {link: d, pnt",
       "robot.yaml:10: points.tip: unknown key 'pnt', did you mean 'point'?; allowed: link, point"},
      {false, "points: {tip", "rest_pose: {j_c: 1}\npoints: {tip",
       "robot.yaml:10: rest_pose.j_c: unknown joint with a motor 'j_c'..."},
      {false, "points: {tip", "rest_pose: {a: 1 m}\npoints: {tip",
       "robot.yaml:10: rest_pose.a: '1 m' is in m; allowed: a number in rad..."},
      {false, "  a: {kind", "  aa: {kind",
       "robot.yaml:12: motors.aa: unknown joint 'aa', did you mean 'a'?; allowed: a, j_b, j_c, "
       "j_d"},
      {false, "kind: electric", "kind: electrical",
       "robot.yaml:12: motors.a.kind: 'electrical' given, did you mean 'electric'?; allowed: ..."},
      {false, "resistance: 0.2,", "",
       "robot.yaml:12: motors.a: key 'resistance' is missing; it must be given"},
      {false, "resistance: 0.2,", "resistance: 0,",
       "robot.yaml:12: motors.a.resistance: 0 is out of range; allowed: at least 1e-12 ohm"},
      {false, "voltage: 16 V", "voltage: 16 A",
       "robot.yaml:12: motors.a.voltage: '16 A' is in A; allowed: a number in V..."},
      {false, "voltage: 16 V", "voltage: \"16\"",
       "robot.yaml:12: motors.a.voltage: '16' has no unit; allowed: a number in V..."},
      {false, "efficiency: 1", "efficiency: 1.2",
       "robot.yaml:12: motors.a.efficiency: 1.2 is out of range; allowed: 1e-12 to 1"},
      {false, "gear: 1", "gear: 0",
       "robot.yaml:12: motors.a.gear: 0 is out of range; allowed: at least 1e-12"},
      {false, "rotor_inertia: 0", "rotor_inertia: -1",
       "robot.yaml:12: motors.a.rotor_inertia: -1 is out of range; allowed: at least 0 kg m^2"},
      {false, "kind: ideal, ", "kind: ideal, gear: 2, ",
       "robot.yaml:13: motors.j_b: unknown key 'gear'..."},
      {false, "  j_b: {kind", "  j_c: {kind",
       "robot.yaml:13: motors.j_c: joint 'j_c' follows from a loop; allowed: motors at independent "
       "joints"},
      {false, "kind: distributed", "kind: disturbed",
       "robot.yaml:15: drag.sail.kind: 'disturbed' given..."},
      {false, "width: 0.2, ", "",
       "robot.yaml:15: drag.sail: sail.drag.width: must be given and above 0 m where kind is "
       "distributed"},
      {false, "start: 0.5", "start: 1.5",
       "robot.yaml:15: drag.sail: sail.drag.end: 1 m given with start 1.5 m; allowed: end above "
       "start"},
      {false, "kind: distributed", "kind: point",
       "robot.yaml:15: drag.sail: sail.drag.point_distance: must be given and above 0 m where kind "
       "is point"},
      {false, "{link: b, direction", "{link: base, direction",
       "robot.yaml:15: drag.sail.link: link 'base' does not begin at a joint; ..."},
      {false, "direction: [0, 1]", "direction: [0, 0]",
       "robot.yaml:15: drag.sail.direction: a direction of length 0 given; allowed: any other"},
      {false, "coefficient: 2", "coeficient: 2",
       "robot.yaml:15: drag.sail: unknown key 'coeficient', did you mean 'coefficient'?; ..."},
  });
}

TEST(BadRobot, Overrides) {
  struct Case {
    const char* text;     ///< the entries of `override`, a line each from line 2 on
    const char* message;  ///< as above
  };
  const std::vector<Case> cases = {
      {"  sail.drag.coeficient: 2\n",
       "p.yaml:2: override.sail.drag.coeficient: unknown model value 'sail.drag.coeficient', did "
       "you mean "
       "'sail.drag.coefficient'?..."},
      {"  motors.*.resistence: 2\n",
       "p.yaml:2: override.motors.*.resistence: unknown model value..."},
      {"  motors.a.resistance: 2 V\n",
       "p.yaml:2: override.motors.a.resistance: '2 V' is in V; allowed: a number in ohm..."},
      {"  motors.a.resistance: 0\n",
       "p.yaml:2: override.motors.a.resistance: 0 is out of range; allowed: at least 1e-12 ohm"},
      {"  bodies.b.mass: -1\n",
       "p.yaml:2: override.bodies.b.mass: -1 is out of range; allowed: at least 1e-12 kg"},
      {"  bodies.b.mass: 1\n  b.mass: 2\n",
       "p.yaml:3: override.b.mass: override 'b.mass' sets bodies.b.mass, which 'bodies.b.mass' "
       "(line 2) sets as well; "
       "allowed: once"},
      {"  motors.*.torque_limit: 1\n  '*.a.torque_limit': 2\n",
       "p.yaml:3: override.*.a.torque_limit: override '*.a.torque_limit' sets..."},
      {"  b.mass: =c.mass\n  c.mass: =d.mass\n  d.mass: =b.mass\n",
       "p.yaml:2: override.b.mass: override goes round in a circle: bodies.b.mass -> bodies.c.mass "
       "-> bodies.d.mass -> "
       "bodies.b.mass; ..."},
      {"  b.mass: =b.mass\n",
       "p.yaml:2: override.b.mass: override goes round in a circle: bodies.b.mass -> "
       "bodies.b.mass; ..."},
      {"  b.mass: =c.mas\n",
       "p.yaml:2: override.b.mass: unknown model value 'c.mas', did you mean 'c.mass'?..."},
      {"  b.mass: =friction\n",
       "p.yaml:2: override.b.mass: friction is 0.8 [-], bodies.b.mass is 2 [kg]; allowed: a value "
       "of the same..."},
      {"  sail.drag.kind: round\n", "p.yaml:2: override.sail.drag.kind: 'round' given..."},
      {"  b.com: 3\n", "p.yaml:2: override.b.com: '3' given; allowed: a list, [a, b, ...]"},
      {"  gravity: .inf\n", "p.yaml:2: override.gravity: '.inf' is not a number..."},
  };
  const testing::Folder folder;
  folder.write("robot.urdf", kUrdf);
  folder.write("robot.yaml", kYaml);
  for (const Case& c : cases) {
    const yaml::Node node = yaml::Node::parse("override:\n" + std::string(c.text), "p.yaml");
    std::vector<Override> overrides;
    for (const auto& [path, value] : node.at("override").entries())
      overrides.push_back({path, value});
    std::string expected = c.message;
    std::string given = "accepted";
    try {
      (void)read_robot(folder.path(), overrides);
    } catch (const InputError& e) {
      given = e.what();
    }
    if (expected.ends_with("...")) {
      expected.resize(expected.size() - 3);
      given = given.substr(0, expected.size());
    }
    EXPECT_EQ(given, expected) << c.text;
  }
}

TEST(BadRobot, FilesThatAreNone) {
  const auto message = [](const std::string& text) -> std::string {
    const testing::Folder folder;
    folder.write("robot.urdf", text);
    try {
      (void)read_urdf(folder.path() / "robot.urdf");
    } catch (const InputError& e) {
      return std::string(e.what()).substr(folder.path().string().size() + 1);
    }
    return "accepted";
  };
  const auto starts = [](const std::string& text, const std::string& head) {
    return text.substr(0, head.size()) == head;
  };
  EXPECT_PRED2(starts, message(""), "robot.urdf:1: ");
  EXPECT_PRED2(starts, message("just words"), "robot.urdf:1: ");
  EXPECT_PRED2(starts, message("<robot name=\"r\"/>"),
               "robot.urdf:1: no <link> given; allowed: at least one");
  EXPECT_PRED2(starts, message(std::string("<robot\0name", 11)), "robot.urdf:1: byte 0x00 found");
  EXPECT_PRED2(starts, message(std::string(10'000'001, 'x')),
               "robot.urdf: holds 10000001 bytes; allowed: at most 10000000");
  std::string deep;
  while (deep.size() < 1'000'000) deep += "<a>\n";
  EXPECT_PRED2(starts, message(deep),
               "robot.urdf:51: elements nested deeper than 50; allowed: less");
  std::mt19937 random(3);
  std::string noise(1'000'000, ' ');
  for (char& c : noise) c = static_cast<char>(random() & 0xFF);
  EXPECT_NE(message(noise), "accepted");
  std::string many = "<robot name=\"r\">";
  for (int i = 0; i < 1001; ++i) many += "\n<link name=\"l" + std::to_string(i) + "\"/>";
  EXPECT_PRED2(starts, message(many + "</robot>"),
               "robot.urdf:1002: 1001 links given; allowed: at most 1000");

  const testing::Folder empty;
  EXPECT_THROW((void)read_robot(empty.path()), InputError);
  EXPECT_THROW((void)read_robot(empty.path() / "absent"), InputError);
  EXPECT_THROW((void)read_urdf(empty.path()), InputError);
}

}  // namespace
}  // namespace jaculus::model
