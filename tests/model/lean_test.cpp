// Joints on axles that lean: their origins are moved along them, and nothing else is.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/model/robot.h"
#include "model/reduce.h"
#include "model/support.h"
#include "support/robot_texts.h"

namespace jaculus::model {
namespace {

constexpr double kRoll = 0.1;  ///< of the axle [rad]

std::string link(const std::string& name, double mass) {
  return fmt::format(
      "<link name=\"{}\"><inertial><origin xyz=\"0.01 0.02 -0.05\"/><mass value=\"{}\"/><inertia "
      "ixx=\"0.01\" iyy=\"0.02\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>",
      name, mass);
}

std::string joint(const std::string& name, const std::string& parent, const std::string& child,
                  const std::string& at, double roll) {
  return fmt::format(
      "<joint name=\"{}\" type=\"continuous\"><parent link=\"{}\"/><child link=\"{}\"/><origin "
      "xyz=\"{}\" rpy=\"{} 0 0\"/><axis xyz=\"0 1 0\"/><limit effort=\"1\" velocity=\"1\"/>"
      "</joint>",
      name, parent, child, at, roll);
}

/// Two motors 8 cm apart on an axle that leans, a knee 3 cm beside the second; `roll` 0: upright.
std::string axle(double roll) {
  const auto on_axle = [&](double y) {
    return fmt::format("0.2 {} {}", y * std::cos(roll), y * std::sin(roll));
  };
  return "<robot name=\"r\">" + link("trunk", 5) + link("left", 1) + link("right", 1) +
         link("shank", 0.5) + joint("a", "trunk", "left", on_axle(0.04), roll) +
         joint("b", "trunk", "right", on_axle(-0.04), roll) +
         joint("knee", "right", "shank", "0 0.03 -0.2", 0.0) + "</robot>";
}

SpatialTree tree_of(const std::string& text) { return parse_urdf(text, "robot.urdf"); }

/// Centres of mass [m] at angles of the joints, in the root's frame.
std::vector<Vec3> centres(const SpatialTree& tree, const std::vector<double>& angles) {
  std::vector<HeldJoint> held;
  for (std::size_t j = 0; j < tree.joints.size(); ++j)
    held.push_back({tree.joints[j].name, angles[j], false});
  const SpatialTree posed = hold_joints(tree, held);
  std::vector<Vec3> all;
  for (const SpatialLink& l : posed.links) all.push_back(l.p_BL + l.R_BL * l.com);
  return all;
}

TEST(Lean, MotorsOnOneAxleTurnAboutOnePlaceOfThePlane) {
  const Reduction r = reduce(tree_of(axle(kRoll)), {}, {}, {});
  ASSERT_EQ(r.bodies.size(), 4u);
  EXPECT_NEAR((r.bodies[1].origin - r.bodies[2].origin).norm(), 0.0, 1e-12);
  // the knee is as far from its hip as in the plane that both turn in, seen along y
  EXPECT_NEAR(r.bodies[3].origin.y(), -0.2 * std::cos(kRoll), 1e-12);
}

TEST(Lean, MovingAnOriginAlongItsAxleMovesNothing) {
  const SpatialTree file = tree_of(axle(kRoll));
  const SpatialTree gathered = gather_leaning(file);
  EXPECT_GT((gathered.links[1].p_BL - file.links[1].p_BL).norm(), 0.03);
  const std::vector<double> angles = {0.7, -1.1, 0.4};
  const std::vector<Vec3> before = centres(file, angles);
  const std::vector<Vec3> after = centres(gathered, angles);
  for (std::size_t l = 0; l < before.size(); ++l)
    EXPECT_NEAR((before[l] - after[l]).norm(), 0.0, 1e-12) << file.links[l].name;
}

TEST(Lean, UprightJointsStayWhereTheFileHasThem) {
  for (const std::string& text : {axle(0.0), test::quadruped_urdf()}) {
    const SpatialTree file = tree_of(text);
    const SpatialTree gathered = gather_leaning(file);
    for (std::size_t l = 0; l < file.links.size(); ++l) {
      EXPECT_EQ(gathered.links[l].p_BL, file.links[l].p_BL);
      EXPECT_EQ(gathered.links[l].com, file.links[l].com);
    }
  }
}

TEST(Lean, MassAndPitchInertiaAtZeroAreTheFiles) {
  const SpatialTree file = tree_of(axle(kRoll));
  double mass = 0.0, inertia = 0.0;
  Vec3 com = Vec3::Zero();
  for (const SpatialLink& l : file.links) {
    mass += l.mass;
    com += l.mass * (l.p_BL + l.R_BL * l.com);
  }
  com /= mass;
  for (const SpatialLink& l : file.links) {
    const Vec3 r = l.p_BL + l.R_BL * l.com - com;
    inertia +=
        (l.R_BL * l.inertia * l.R_BL.transpose())(1, 1) + l.mass * (r.x() * r.x() + r.z() * r.z());
  }

  const Reduction planar = reduce(file, {}, {}, {});
  double planar_inertia = 0.0;
  std::vector<testing::Pose> at(planar.bodies.size());
  for (std::size_t b = 0; b < planar.bodies.size(); ++b) {
    const PlanarBody& body = planar.bodies[b];
    if (b > 0)
      at[b] = {at[static_cast<std::size_t>(body.parent)].at(body.origin),
               at[static_cast<std::size_t>(body.parent)].phi + body.angle_offset};
    planar_inertia +=
        body.inertia + body.mass * (at[b].at(body.com) - Vec2(com.x(), com.z())).squaredNorm();
  }
  EXPECT_NEAR(planar_inertia, inertia, 1e-12 * inertia);
}

}  // namespace
}  // namespace jaculus::model
