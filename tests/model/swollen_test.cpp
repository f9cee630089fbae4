// Inertias that are place holders, and what takes their place.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "jaculus/model/propose.h"

namespace jaculus::model {
namespace {

std::string joint(const std::string& parent, const std::string& child, const std::string& origin) {
  return fmt::format(
      "<joint name=\"{1}_joint\" type=\"continuous\"><parent link=\"{0}\"/><child "
      "link=\"{1}\"/><origin xyz=\"{2}\"/><axis xyz=\"0 1 0\"/></joint>\n",
      parent, child, origin);
}

TEST(Swollen, PlaceHoldersOfInertiasGiveWayToThoseOfShapes) {
  const auto body = [](const std::string& name, double moment, const std::string& shapes) {
    return fmt::format(
        "<link name=\"{0}\"><inertial><origin xyz=\"0 0 -0.1\"/><mass value=\"2\"/><inertia "
        "ixx=\"{1}\" iyy=\"{1}\" izz=\"{1}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{2}"
        "</link>\n",
        name, moment, shapes);
  };
  const auto shape = [](const std::string& turned, const std::string& text) {
    return "<collision><origin rpy=\"" + turned + "\"/><geometry>" + text +
           "</geometry></collision>";
  };
  SpatialTree tree = parse_urdf(
      "<robot name=\"first_draft\">" +
          body("trunk", 1.0,
               shape("0 0 0", "<box size=\"0.3 0.2 0.1\"/>") +
                   shape("0 0 0", "<sphere radius=\"0.01\"/>")) +
          body("rod", 1.0,
               shape("0 1.5707963267948966 0", "<cylinder radius=\"0.02\" length=\"0.3\"/>")) +
          body("ball", 100.0, "") + body("known", 0.004, shape("0 0 0", "<box size=\"1 1 1\"/>")) +
          joint("trunk", "rod", "0.1 0 0") + joint("rod", "ball", "0 0 -0.2") +
          joint("ball", "known", "0 0 -0.2") + "</robot>",
      "robot.urdf");

  EXPECT_EQ(take_inertias_of_shapes(tree), (std::vector<std::string>{"trunk", "rod", "ball"}));
  const auto moments = [&](const char* name) -> Vec3 {
    return tree.links[tree.link_index(name)].inertia.diagonal();
  };
  EXPECT_NEAR(moments("trunk").y(), 2.0 / 12.0 * (0.3 * 0.3 + 0.1 * 0.1), 1e-12);
  EXPECT_NEAR(moments("trunk").z(), 2.0 / 12.0 * (0.3 * 0.3 + 0.2 * 0.2), 1e-12);
  // a cylinder along x
  EXPECT_NEAR(moments("rod").x(), 0.5 * 2.0 * 0.02 * 0.02, 1e-12);
  EXPECT_NEAR(moments("rod").y(), 2.0 * (0.02 * 0.02 / 4.0 + 0.3 * 0.3 / 12.0), 1e-12);
  // 2 kg of water: r = 78.2 mm
  EXPECT_NEAR(moments("ball").x(), 0.4 * 2.0 * 0.0782 * 0.0782, 1e-5);
  EXPECT_EQ(moments("known").x(), 0.004);
}

}  // namespace
}  // namespace jaculus::model
