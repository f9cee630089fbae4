#include <fmt/format.h>

#include <cmath>

#include "jaculus/model/mjcf.h"

namespace jaculus::model {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out.push_back(c);
    }
  }
  return out;
}

std::string triple(const Vec3& v) { return fmt::format("{} {} {}", v.x(), v.y(), v.z()); }

/// Roll, pitch, yaw of R = Rz(yaw) Ry(pitch) Rx(roll).
Vec3 rpy_of(const Mat3& R) {
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  // roll and yaw turn about one axis where the pitch is a right angle
  if (std::hypot(R(0, 0), R(1, 0)) < 1e-12) return {0.0, pitch, std::atan2(-R(0, 1), R(1, 1))};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

std::string origin(const Vec3& position, const Mat3& rotation) {
  return fmt::format("<origin xyz=\"{}\" rpy=\"{}\"/>", triple(position), triple(rpy_of(rotation)));
}

std::string shape_text(const SpatialShape& shape) {
  const Vec3& s = shape.size;
  std::string kind;
  switch (shape.kind) {
    case ShapeKind::sphere:
      kind = fmt::format("<sphere radius=\"{}\"/>", s[0]);
      break;
    case ShapeKind::box:
      kind = fmt::format("<box size=\"{}\"/>", triple(2.0 * s));
      break;
    case ShapeKind::cylinder:
      kind = fmt::format("<cylinder radius=\"{}\" length=\"{}\"/>", s[0], 2.0 * s[2]);
      break;
    case ShapeKind::capsule:
      kind = fmt::format("<capsule radius=\"{}\" length=\"{}\"/>", s[0], 2.0 * s[2]);
      break;
  }
  return fmt::format("    <{0}>{1}<geometry>{2}</geometry></{0}>\n",
                     shape.touches ? "collision" : "visual", origin(shape.position, shape.rotation),
                     kind);
}

std::string link_text(const SpatialLink& link) {
  std::string text = fmt::format("  <link name=\"{}\">\n", escaped(link.name));
  if (link.mass > 0.0) {
    const Mat3& I = link.inertia;
    text += fmt::format(
        "    <inertial><origin xyz=\"{}\"/><mass value=\"{}\"/>\n"
        "      <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/>\n"
        "    </inertial>\n",
        triple(link.com), link.mass, I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2));
  }
  for (const SpatialShape& shape : link.shapes) text += shape_text(shape);
  return text + "  </link>\n";
}

std::string joint_text(const SpatialTree& tree, const SpatialJoint& joint) {
  const bool ranged = std::isfinite(joint.range.lower) && std::isfinite(joint.range.upper);
  const bool slides = joint.kind == SpatialJointKind::prismatic;
  const char* type = joint.kind == SpatialJointKind::fixed ? "fixed"
                     : slides                              ? "prismatic"
                     : ranged                              ? "revolute"
                                                           : "continuous";
  std::string text = fmt::format(
      "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{}\"/><child link=\"{}\"/>\n    {}\n",
      escaped(joint.name), type, escaped(tree.links[joint.parent].name),
      escaped(tree.links[joint.child].name), origin(joint.origin, joint.rotation));
  if (joint.kind == SpatialJointKind::fixed) return text + "  </joint>\n";

  text += fmt::format("    <axis xyz=\"{}\"/>\n", triple(joint.axis));
  // 0 stands for what nobody knows
  const auto known = [](double value) { return std::isfinite(value) ? value : 0.0; };
  constexpr double kFar = 1e3;  // [m]: a slide without a range needs one in URDF
  const std::string range =
      ranged   ? fmt::format("lower=\"{}\" upper=\"{}\" ", joint.range.lower, joint.range.upper)
      : slides ? fmt::format("lower=\"{}\" upper=\"{}\" ", -kFar, kFar)
               : "";
  text += fmt::format("    <limit {}effort=\"{}\" velocity=\"{}\"/>\n", range, known(joint.effort),
                      known(joint.velocity));
  if (joint.damping != 0.0 || joint.friction != 0.0)
    text += fmt::format("    <dynamics damping=\"{}\" friction=\"{}\"/>\n", joint.damping,
                        joint.friction);
  return text + "  </joint>\n";
}

}  // namespace

void keep_friction(const SpatialTree& written, SpatialTree& tree) {
  constexpr double kSamePlace = 1e-9;  // [m]: far beyond rounding, far below a robot's parts
  for (SpatialLink& link : tree.links) {
    const int from = written.link_index(link.name);
    if (from < 0) continue;
    for (SpatialShape& shape : link.shapes)
      for (const SpatialShape& was : written.links[from].shapes)
        if (was.kind == shape.kind && (was.position - shape.position).norm() < kSamePlace &&
            (was.size - shape.size).norm() < kSamePlace)
          shape.friction = was.friction;
  }
}

std::string write_urdf(const SpatialTree& tree) {
  std::string text =
      fmt::format("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", escaped(tree.name));
  for (const SpatialLink& link : tree.links) text += link_text(link);
  for (const SpatialJoint& joint : tree.joints) text += joint_text(tree, joint);
  return text + "</robot>\n";
}

}  // namespace jaculus::model
