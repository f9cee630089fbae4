// Bad robot.yaml files: each is one edit of a good robot, and each message names the place, what
// was given, what is allowed.

#include "model/bad_robot.h"

#include <gtest/gtest.h>

#include "jaculus/model/robot.h"
#include "model/support.h"

namespace jaculus::model {
namespace {

using testing::expect_faults;
using testing::kUrdf;
using testing::kYaml;

TEST(BadRobot, TheRobotItselfIsGood) {
  const testing::Folder folder;
  folder.write("robot.urdf", kUrdf);
  folder.write("robot.yaml", kYaml);
  const PlanarModel m = read_robot(folder.path()).planar;
  EXPECT_EQ(m.size(), 5);
  EXPECT_EQ(m.joint_ranges.size(), 2u);
  EXPECT_EQ(m.bodies.size(), 5u);
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

}  // namespace
}  // namespace jaculus::model
