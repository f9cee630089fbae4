// Which plane a robot moves in, which way is forward and up, and where its base begins.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "model/propose/draft.h"

namespace jaculus::model {
namespace {

std::string axis_name(const Vec3& v) {
  int i = 0;
  v.cwiseAbs().maxCoeff(&i);
  return fmt::format("{}{}", v[i] < 0.0 ? '-' : '+', "xyz"[i]);
}

Vec3 axis_of(const std::string& name) {
  Vec3 v = Vec3::Zero();
  v[name.at(1) - 'x'] = name.at(0) == '-' ? -1.0 : 1.0;
  return v;
}

bool turns(const SpatialJoint& joint) { return joint.kind == SpatialJointKind::revolute; }

Vec3 axis_in_root(const SpatialTree& tree, const SpatialJoint& joint) {
  return tree.links[joint.child].R_BL * joint.axis;
}

/// The axis that most joints turn about: y before x where as many do, and z only where nothing
/// turns about the others.
int lateral_axis(const SpatialTree& tree) {
  std::array<int, 3> count{};
  for (const SpatialJoint& joint : tree.joints) {
    if (!turns(joint)) continue;
    const Vec3 axis = axis_in_root(tree, joint);
    for (int i = 0; i < 3; ++i)
      if (std::abs(axis[i]) > kAlong) ++count[static_cast<std::size_t>(i)];
  }
  if (count[1] == 0 && count[0] == 0) return count[2] > 0 ? 2 : 1;
  return count[0] > count[1] ? 0 : 1;
}

/// Joints that the root's rigid body carries.
std::vector<int> first_joints(const SpatialTree& tree) {
  std::vector<int> joints;
  for (int j = 0; j < count_of(tree.joints); ++j) {
    if (tree.joints[j].kind == SpatialJointKind::fixed) continue;
    int link = tree.joints[j].parent;
    while (link != tree.root && tree.joints[tree.links[link].joint].kind == SpatialJointKind::fixed)
      link = tree.joints[tree.links[link].joint].parent;
    if (link == tree.root) joints.push_back(j);
  }
  return joints;
}

/// Mean way from where limbs begin to where they end, in the root's axes [m].
Vec3 reach(const SpatialTree& tree) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const int j : first_joints(tree)) {
    const SpatialTree limb = subtree(tree, tree.joints[j].child);
    std::set<int> parents;
    for (const SpatialJoint& joint : limb.joints) parents.insert(joint.parent);
    for (int l = 0; l < count_of(limb.links); ++l) {
      if (parents.count(l) != 0) continue;
      sum += limb.links[l].p_BL - tree.links[tree.joints[j].child].p_BL;
      ++count;
    }
  }
  return count == 0 ? sum : Vec3(sum / count);
}

/// Up: z, or y where joints turn about z, or about x and limbs hang along y rather than z.
Vec3 up_axis(const SpatialTree& tree, int lateral) {
  if (lateral == 2) return Vec3::UnitY();
  if (lateral == 1) return Vec3::UnitZ();
  const Vec3 way = reach(tree);
  const bool hangs = first_joints(tree).size() > 1 && std::abs(way.y()) > std::abs(way.z()) + 1e-3;
  if (!hangs) return Vec3::UnitZ();
  return way.y() < 0.0 ? Vec3::UnitY() : Vec3(-Vec3::UnitY());
}

/// Forward: where names say front, or what left and right ask for, else the positive axis.
Vec3 forward_axis(const SpatialTree& tree, int lateral, const Vec3& up, bool& named) {
  Vec3 left = Vec3::Zero();
  left[lateral] = 1.0;
  Vec3 forward = left.cross(up);
  if (forward.sum() < 0.0) forward = -forward;

  double front = 0.0;
  double sides = 0.0;
  for (const SpatialJoint& joint : tree.joints) {
    const Vec3& p = tree.links[joint.child].p_BL;
    front += end_of_name(joint.name) * p.dot(forward);
    sides += side_of_name(joint.name) * p.dot(up.cross(forward));
  }
  // a robot without front and rear has left and right all the same
  if (std::abs(front) <= 1e-3) front = sides;
  named = std::abs(front) > 1e-3;
  return front < -1e-3 ? Vec3(-forward) : forward;
}

void turn_root(SpatialTree& tree, const Vec3& forward, const Vec3& up) {
  Mat3 R;
  R.row(0) = forward;
  R.row(1) = up.cross(forward);
  R.row(2) = up;
  tree.links[tree.root].R_BL = R;
  place_links(tree);
}

/// The link that a chain of x, z and pitch from the root ends at, as planar robots have it for
/// their base; -1 where there is none.
int end_of_base_chain(const SpatialTree& tree) {
  const double total = [&] {
    double sum = 0.0;
    for (const SpatialLink& link : tree.links) sum += link.mass;
    return sum;
  }();
  std::set<char> seen;
  double above = 0.0;
  int link = tree.root;

  while (seen.size() < 3) {
    above += tree.links[link].mass;
    if (above > 0.01 * total) return -1;  // a base's joints carry dummies
    int only = -1;
    for (int j = 0; j < count_of(tree.joints); ++j) {
      if (tree.joints[j].parent != link) continue;
      if (only >= 0) return -1;
      only = j;
    }
    if (only < 0) return -1;
    const SpatialJoint& joint = tree.joints[only];
    const Vec3 axis = axis_in_root(tree, joint).cwiseAbs();
    link = joint.child;
    if (joint.kind == SpatialJointKind::fixed) continue;
    const char kind = turns(joint) && axis.y() > kAlong    ? 'p'
                      : !turns(joint) && axis.x() > kAlong ? 'x'
                      : !turns(joint) && axis.z() > kAlong ? 'z'
                                                           : '?';
    if (kind == '?' || !seen.insert(kind).second) return -1;
  }
  return link;
}

/// Whether a base that no chain of joints carries floats: nothing moves, or two limbs or more turn
/// in the plane.
bool seems_floating(const SpatialTree& tree) {
  const bool rigid = std::none_of(tree.joints.begin(), tree.joints.end(), [](const auto& joint) {
    return joint.kind != SpatialJointKind::fixed;
  });
  if (rigid) return true;

  int limbs = 0;
  for (const int j : first_joints(tree)) {
    const SpatialTree limb = subtree(tree, tree.joints[j].child);
    const bool moves =
        turns(tree.joints[j]) && std::abs(axis_in_root(tree, tree.joints[j]).y()) > kAlong;
    const bool later = std::any_of(limb.joints.begin(), limb.joints.end(), [&](const auto& joint) {
      return turns(joint) && std::abs(axis_in_root(limb, joint).y()) > kAlong;
    });
    limbs += moves || later ? 1 : 0;
  }
  return limbs >= 2;
}

}  // namespace

void find_frame(const SpatialTree& file, const ProposeOptions& options, Draft& draft) {
  draft.tree = file;
  const bool stated = !options.forward.empty() && !options.up.empty();
  int lateral = lateral_axis(file);
  bool named = false;
  const Vec3 up = stated ? axis_of(options.up) : up_axis(file, lateral);
  const Vec3 forward = stated ? axis_of(options.forward) : forward_axis(file, lateral, up, named);
  up.cross(forward).cwiseAbs().maxCoeff(&lateral);
  draft.forward = axis_name(forward);
  draft.up = axis_name(up);
  // a mechanism of one limb that turns about z lies flat; a body with several has its y upwards
  draft.horizontal = !stated && lateral == 2 && first_joints(file).size() < 2;
  turn_root(draft.tree, forward, up);

  draft.notes.push_back(fmt::format(
      "the plane lies across the file's {}, which joints turn about: forward is {} ({}), up is "
      "{}{}",
      "xyz"[lateral], draft.forward,
      stated  ? "as stated"
      : named ? "by the names of joints"
              : "by custom",
      draft.up, draft.horizontal ? "; the plane lies flat, so there is no gravity in it" : ""));

  const int base = end_of_base_chain(draft.tree);
  if (base >= 0) {
    draft.base_link = draft.tree.links[base].name;
    draft.notes.push_back(fmt::format(
        "joints along x, z and about y carry '{}': they are its floating base", draft.base_link));
    draft.tree = subtree(draft.tree, base);
  }
  draft.floating =
      options.floating.value_or(base >= 0 || (!draft.horizontal && seems_floating(draft.tree)));
  if (base < 0) {
    draft.notes.push_back(fmt::format("base: {} ({})", draft.floating ? "floating" : "fixed",
                                      options.floating ? "as stated"
                                      : draft.floating ? "several limbs move in the plane"
                                                       : "at most one limb moves in the plane"));
  }
}

}  // namespace jaculus::model
