#pragma once
// A good robot, and what becomes of it with one edit.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "jaculus/model/robot.h"
#include "model/support.h"

namespace jaculus::testing {

// One element a line, so that the lines below can be counted. Joint b and c carry a crank and a
// coupler that meet rocker d.
inline const char* const kUrdf =
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

inline const char* const kYaml =
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

inline std::string fault(const Bad& c) {
  const Folder folder;
  folder.write("robot.urdf", c.urdf ? replaced(kUrdf, c.from, c.to) : kUrdf);
  folder.write("robot.yaml", c.urdf ? kYaml : replaced(kYaml, c.from, c.to));
  try {
    (void)model::read_robot(folder.path(), {}, model::Reading::strict);
  } catch (const InputError& e) {
    const std::string what = e.what();
    const std::string prefix = folder.path().string() + "/";
    EXPECT_TRUE(what.starts_with(prefix)) << what;
    return what.starts_with(prefix) ? what.substr(prefix.size()) : what;
  }
  return "accepted";
}

inline void expect_faults(const std::vector<Bad>& cases) {
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

}  // namespace jaculus::testing
