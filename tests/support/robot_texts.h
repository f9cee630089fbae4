#pragma once
// Robot files as texts, for tests of the importer: a quadruped with abduction, and the same in
// MJCF.

#include <fmt/format.h>

#include <string>

namespace jaculus::test {

/// A leg: hip (abduction about x), thigh, shank and a toe of 2 cm. `y`: +1 left, -1 right.
inline std::string quadruped_leg(const std::string& name, double x, double y) {
  const auto link = [](const std::string& link_name, const std::string& com, double mass) {
    return fmt::format(
        "<link name=\"{}\"><inertial><origin xyz=\"{}\"/><mass value=\"{}\"/><inertia ixx=\"2e-3\" "
        "iyy=\"3e-3\" izz=\"2e-3\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\n",
        link_name, com, mass);
  };
  const auto joint = [](const std::string& joint_name, const std::string& type,
                        const std::string& parent, const std::string& child,
                        const std::string& origin, const std::string& axis,
                        const std::string& range) {
    return fmt::format(
        "<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/><origin "
        "xyz=\"{}\"/>"
        "<axis xyz=\"{}\"/><limit {} effort=\"25\" velocity=\"20\"/></joint>\n",
        joint_name, type, parent, child, origin, axis, range);
  };

  const std::string toe = fmt::format(
      "<link name=\"{0}_toe\"><contact/><collision><geometry><sphere radius=\"0.02\"/></geometry>"
      "</collision></link>\n<joint name=\"{0}_toe_fixed\" type=\"fixed\"><parent "
      "link=\"{0}_shank\"/>"
      "<child link=\"{0}_toe\"/><origin xyz=\"0 0 -0.2\"/></joint>\n",
      name);
  return link(name + "_hip", fmt::format("0 {} 0", 0.02 * y), 0.5) +
         link(name + "_thigh", fmt::format("0 {} -0.05", 0.01 * y), 0.8) +
         link(name + "_shank", "0 0 -0.1", 0.2) + toe +
         joint(name + "_abduct", "revolute", "trunk", name + "_hip",
               fmt::format("{} {} 0", x, 0.05 * y), "1 0 0", "lower=\"-0.8\" upper=\"0.8\"") +
         joint(name + "_hip_joint", "revolute", name + "_hip", name + "_thigh",
               fmt::format("0 {} 0", 0.08 * y), "0 1 0", "lower=\"-1\" upper=\"4\"") +
         joint(name + "_knee_joint", "revolute", name + "_thigh", name + "_shank", "0 0 -0.2",
               "0 1 0", "lower=\"-2.7\" upper=\"-0.9\"");
}

inline std::string quadruped_urdf() {
  return "<robot name=\"hound\">\n<link name=\"trunk\"><inertial><mass value=\"6\"/><inertia "
         "ixx=\"0.02\" iyy=\"0.08\" izz=\"0.09\" ixy=\"0\" ixz=\"0\" "
         "iyz=\"0\"/></inertial></link>\n" +
         quadruped_leg("FL", 0.2, 1.0) + quadruped_leg("FR", 0.2, -1.0) +
         quadruped_leg("RL", -0.2, 1.0) + quadruped_leg("RR", -0.2, -1.0) + "</robot>\n";
}

/// The same with a limb of two links in the middle of its trunk, over (x, z) from its origin: drawn
/// along `way`, its last link 2 g like a finger, with motors that never saturate.
inline std::string quadruped_with_limb(double x, double z, const std::string& way) {
  const auto link = [&](const std::string& name, double mass, double inertia) {
    return fmt::format(
        "<link name=\"{0}\"><inertial><origin xyz=\"{1}\"/><mass value=\"{2}\"/><inertia "
        "ixx=\"{3}\" iyy=\"{3}\" izz=\"{3}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>"
        "<collision><origin xyz=\"{1}\"/><geometry><sphere radius=\"0.01\"/></geometry>"
        "</collision></link>\n",
        name, way, mass, inertia);
  };
  const auto joint = [](const std::string& name, const std::string& parent,
                        const std::string& child, const std::string& origin) {
    return fmt::format(
        "<joint name=\"{}\" type=\"revolute\"><parent link=\"{}\"/><child link=\"{}\"/><origin "
        "xyz=\"{}\"/><axis xyz=\"0 1 0\"/><limit lower=\"-2\" upper=\"2\" effort=\"1e5\" "
        "velocity=\"9\"/></joint>\n",
        name, parent, child, origin);
  };
  std::string text = quadruped_urdf();
  text.erase(text.rfind("</robot>"));
  return text + link("upper", 0.4, 2e-3) + link("finger", 0.002, 1e-6) +
         joint("shoulder", "trunk", "upper", fmt::format("{} 0 {}", x, z)) +
         joint("wrist", "upper", "finger", way) + "</robot>\n";
}

/// A hopper on a chain of slides and a hinge, of one box and a leg with a foot, in MuJoCo's format.
inline const char* const kHopperMjcf = R"(<mujoco model="hopper">
  <compiler angle="radian"/>
  <worldbody>
    <geom type="plane" size="5 5 1"/>
    <body name="trunk" pos="0 0 1">
      <joint name="slide_x" type="slide" axis="1 0 0"/>
      <joint name="slide_z" type="slide" axis="0 0 1"/>
      <joint name="pitch" type="hinge" axis="0 1 0"/>
      <geom name="box" type="box" size="0.1 0.05 0.15" mass="4"/>
      <body name="thigh" pos="0 0 -0.2">
        <joint name="hip" type="hinge" axis="0 1 0" pos="0 0 0.05" range="-1 1" limited="true"
          armature="0.02" damping="0.1"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="1"/>
        <body name="foot" pos="0 0 -0.3">
          <joint name="knee" type="hinge" axis="0 -1 0" range="-2 0" limited="true"/>
          <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.5"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor joint="hip" gear="50" ctrlrange="-1 1" ctrllimited="true"/>
    <motor joint="knee" gear="30" ctrlrange="-2 2" ctrllimited="true" forcerange="-1 1"
      forcelimited="true"/>
  </actuator>
</mujoco>
)";

}  // namespace jaculus::test
