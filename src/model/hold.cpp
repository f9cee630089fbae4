// Joints that are held: they are fixed where they are.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "model/reduce.h"

namespace jaculus::model {

SpatialTree hold_joints(const SpatialTree& spatial, const std::vector<HeldJoint>& held) {
  SpatialTree tree = spatial;
  for (const HeldJoint& hold : held) {
    SpatialJoint& joint = tree.joints[tree.joint_index(hold.joint)];
    if (joint.kind == SpatialJointKind::prismatic)
      joint.origin += joint.rotation * joint.axis * hold.value;
    if (joint.kind == SpatialJointKind::revolute) {
      joint.rotation =
          joint.rotation * Eigen::AngleAxisd(hold.value, joint.axis).toRotationMatrix();
    }
    joint.kind = SpatialJointKind::fixed;
  }
  place_links(tree);
  return tree;
}

void hold_massless(SpatialTree& tree, const std::vector<PairSpec>& pairs,
                   Assumptions& assumptions) {
  const auto below = [&](int link) { return subtree(tree, link).total_mass(); };

  for (SpatialJoint& joint : tree.joints) {
    if (joint.kind == SpatialJointKind::fixed || below(joint.child) > 0.0) continue;
    const SpatialLink& link = tree.links[joint.child];
    const std::string fault = fmt::format(
        "link '{}' moves but has no mass; allowed: <inertial> with a mass above 0", link.name);
    const bool paired = std::any_of(pairs.begin(), pairs.end(), [&](const PairSpec& pair) {
      return pair.left == joint.name || pair.right == joint.name;
    });
    if (paired) assumptions.refuse(link.line, fault);
    assumptions.assume(link.line, fault, "joint '" + joint.name + "' is held at zero");
    joint.kind = SpatialJointKind::fixed;
  }
}

}  // namespace jaculus::model
