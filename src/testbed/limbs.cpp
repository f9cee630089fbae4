#include "testbed/limbs.h"

#include <algorithm>

namespace jaculus::testbed {
namespace {

/// A link and those between it and the base that move.
std::vector<int> chain(const model::SpatialTree& tree, int link) {
  std::vector<int> links;
  for (int joint = moving_joint(tree, link); joint >= 0; joint = moving_joint(tree, link)) {
    links.push_back(link);
    const int moved = tree.joints[joint].child;
    if (moved != link) links.push_back(moved);
    link = tree.joints[joint].parent;
  }
  return links;
}

/// Where a link's chain leaves the base, at the joints' zero [m].
double root_x(const model::SpatialTree& tree, int link) {
  const std::vector<int> links = chain(tree, link);
  return links.empty() ? 0.0 : tree.links[links.back()].p_BL.x();
}

void mark(std::vector<Limb>& limbs, const std::vector<int>& links, Limb limb) {
  for (const int link : links)
    if (limbs[link] == Limb::other) limbs[link] = limb;
}

/// The chains that pins close with those of a limb.
void mark_closed(const model::SpatialTree& tree, const std::vector<Pin>& pins,
                 std::vector<Limb>& limbs, Limb limb) {
  for (bool more = true; more;) {
    const std::vector<Limb> before = limbs;
    for (const Pin& pin : pins) {
      const int a = tree.link_index(pin.link_a), b = tree.link_index(pin.link_b);
      if (limbs[a] == limb) mark(limbs, chain(tree, b), limb);
      if (limbs[b] == limb) mark(limbs, chain(tree, a), limb);
    }
    more = limbs != before;
  }
}

/// What hangs on links of a limb belongs to it.
void mark_carried(const model::SpatialTree& tree, std::vector<Limb>& limbs) {
  for (bool more = true; more;) {
    const std::vector<Limb> before = limbs;
    for (const model::SpatialJoint& joint : tree.joints) {
      if (limbs[joint.child] == Limb::other) limbs[joint.child] = limbs[joint.parent];
    }
    more = limbs != before;
  }
}

}  // namespace

int moving_joint(const model::SpatialTree& tree, int link) {
  int joint = tree.links[link].joint;
  while (joint >= 0 && tree.joints[joint].kind == model::SpatialJointKind::fixed)
    joint = tree.links[tree.joints[joint].parent].joint;
  return joint;
}

std::vector<Limb> limbs_of_links(const model::SpatialTree& tree,
                                 const std::vector<std::string>& drag_links,
                                 const std::vector<Toe>& toes, const std::vector<Pin>& pins) {
  std::vector<Limb> limbs(tree.links.size(), Limb::other);
  for (const std::string& link : drag_links)
    mark(limbs, chain(tree, tree.link_index(link)), Limb::tail);
  mark_carried(tree, limbs);

  double front_x = -kInfinity, rear_x = kInfinity;
  for (const Toe& toe : toes) {
    const double x = root_x(tree, tree.link_index(toe.link));
    front_x = std::max(front_x, x);
    rear_x = std::min(rear_x, x);
  }

  for (const Toe& toe : toes) {
    const int link = tree.link_index(toe.link);
    const double x = root_x(tree, link);
    const bool front = front_x > rear_x && x > 0.5 * (front_x + rear_x);
    mark(limbs, chain(tree, link), front ? Limb::front_leg : Limb::rear_leg);
  }
  mark_closed(tree, pins, limbs, Limb::front_leg);
  mark_closed(tree, pins, limbs, Limb::rear_leg);
  mark_carried(tree, limbs);
  return limbs;
}

}  // namespace jaculus::testbed
