// Axes and base link of robot.yaml: how the file's frame lies in the robot's.

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "model/sections.h"

namespace jaculus::model {
namespace {

const std::vector<std::string> kDirections = {"+x", "-x", "+y", "-y", "+z", "-z"};

Vec3 direction(const yaml::Node& node) {
  const int i = index_of(kDirections, node.choice(kDirections));
  Vec3 v = Vec3::Zero();
  v[i / 2] = i % 2 == 0 ? 1.0 : -1.0;
  return v;
}

/// axes: file axes to the robot's, rows forward, left and up in the file's frame.
Mat3 read_axes(const yaml::Node& robot) {
  const auto axes = robot.find("axes");
  if (!axes) return Mat3::Identity();
  axes->only({"forward", "up"});
  const Vec3 forward = direction(axes->at("forward"));
  const Vec3 up = direction(axes->at("up"));
  if (forward.dot(up) != 0.0)
    throw axes->error("forward and up lie on one line; allowed: two axes of the file's root");

  Mat3 R;
  R.row(0) = forward;
  R.row(1) = up.cross(forward);
  R.row(2) = up;
  return R;
}

}  // namespace

SpatialTree read_placement(const yaml::Node& robot, const SpatialTree& tree,
                           std::vector<std::string>& notes) {
  SpatialTree placed = tree;
  placed.links[placed.root].R_BL = read_axes(robot);
  place_links(placed);

  const auto base = robot.find("base_link");
  if (!base) return placed;
  const int root = placed.link_index(base->text());
  if (root < 0) {
    std::vector<std::string> names;
    for (const SpatialLink& link : placed.links) names.push_back(link.name);
    throw unknown_name(*base, "link", base->text(), names);
  }

  const SpatialTree part = subtree(placed, root);
  notes.push_back(fmt::format("links above '{}', {:.3g} kg, are left out", base->text(),
                              placed.total_mass() - part.total_mass()));
  return part;
}

}  // namespace jaculus::model
