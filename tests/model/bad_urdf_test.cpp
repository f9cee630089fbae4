// Bad URDF files: edits of a good robot's, and files that are none. Each message names the place,
// what was given, what is allowed.

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "jaculus/model/robot.h"
#include "jaculus/model/urdf.h"
#include "model/bad_robot.h"
#include "model/support.h"

namespace jaculus::model {
namespace {

using testing::expect_faults;

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
