// Joints whose axes lean out of the plane: where along its axis a joint's origin is said to be is
// the file's choice, and moves nothing. Projected along y, it does: motors side by side on an axle
// that leans would turn about two places of the plane.

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <vector>

#include "jaculus/model/tolerances.h"
#include "model/reduce.h"

namespace jaculus::model {
namespace {

/// Axes that differ by less are parallel, and what is less from upright doesn't lean [rad].
constexpr double kParallel = 1e-3;

Vec3 axis_in_root(const SpatialTree& tree, const SpatialJoint& joint) {
  return tree.links[joint.child].R_BL * joint.axis;
}

bool is_parallel(const Vec3& a, const Vec3& b) { return a.cross(b).norm() < kParallel; }

bool leans(const SpatialTree& tree, const SpatialJoint& joint) {
  if (joint.kind != SpatialJointKind::revolute) return false;
  const Vec3 axis = axis_in_root(tree, joint);
  return !is_parallel(axis, Vec3::UnitY()) && std::abs(axis.y()) > std::cos(kLean);
}

/// Moves a joint's origin along its axis [m]; all links stay where they are.
void slide(SpatialTree& tree, int index, double distance) {
  SpatialJoint& joint = tree.joints[index];
  const Vec3 by = joint.axis * distance;  // in the child's frame
  joint.origin += joint.rotation * by;
  SpatialLink& link = tree.links[joint.child];
  link.com -= by;
  for (SpatialShape& shape : link.shapes) shape.position -= by;
  for (SpatialJoint& next : tree.joints)
    if (next.parent == joint.child) next.origin -= by;
  place_links(tree);
}

/// The next joint towards the root that moves, or -1.
int carrier(const SpatialTree& tree, int index) {
  int j = tree.links[tree.joints[index].parent].joint;
  while (j >= 0 && tree.joints[j].kind == SpatialJointKind::fixed)
    j = tree.links[tree.joints[j].parent].joint;
  return j;
}

/// The joints of one axle: on one line with `index`, on the same carrier, itself among them.
std::vector<int> axle_of(const SpatialTree& tree, int index) {
  const Vec3 axis = axis_in_root(tree, tree.joints[index]);
  const Vec3& at = tree.links[tree.joints[index].child].p_BL;
  std::vector<int> axle;
  for (int j = 0; j < count_of(tree.joints); ++j) {
    if (!leans(tree, tree.joints[j]) || carrier(tree, j) != carrier(tree, index)) continue;
    const Vec3 apart = tree.links[tree.joints[j].child].p_BL - at;
    if (is_parallel(axis_in_root(tree, tree.joints[j]), axis) &&
        apart.cross(axis).norm() < Tolerances{}.com)
      axle.push_back(j);
  }
  return axle;
}

/// How far along its axis a joint goes: to the plane of the joint that carries it, or to the middle
/// of its axle [m].
double way_of(const SpatialTree& tree, int index) {
  const Vec3 axis = axis_in_root(tree, tree.joints[index]);
  const auto along = [&](int j) { return axis.dot(tree.links[tree.joints[j].child].p_BL); };
  const int above = carrier(tree, index);
  if (above >= 0 && leans(tree, tree.joints[above]) &&
      is_parallel(axis_in_root(tree, tree.joints[above]), axis))
    return along(above) - along(index);

  const std::vector<int> axle = axle_of(tree, index);
  double sum = 0.0;
  for (const int j : axle) sum += along(j);
  return sum / static_cast<double>(axle.size()) - along(index);
}

}  // namespace

SpatialTree gather_leaning(SpatialTree tree) {
  // by how many joints carry them: an axle as one, and before those that hang on it
  std::map<int, std::vector<int>> by_depth;
  for (int j = 0; j < count_of(tree.joints); ++j) {
    if (!leans(tree, tree.joints[j])) continue;
    int depth = 0;
    for (int above = carrier(tree, j); above >= 0; above = carrier(tree, above)) ++depth;
    by_depth[depth].push_back(j);
  }

  for (const auto& [depth, joints] : by_depth) {
    std::vector<double> ways;
    for (const int j : joints) ways.push_back(way_of(tree, j));
    for (std::size_t i = 0; i < joints.size(); ++i) slide(tree, joints[i], ways[i]);
  }
  return tree;
}

}  // namespace jaculus::model
