#include "testbed/parts.h"

namespace jaculus::testbed {
namespace {

/// Adds (sign 1) or takes away (-1) a part: masses, centres of mass, pitch inertia by the
/// parallel-axis theorem.
void merge(Part& whole, const Part& part, double sign) {
  const double mass = whole.mass + sign * part.mass;
  if (mass <= 0.0) return;
  const model::Vec3 com = (whole.mass * whole.com + sign * part.mass * part.com) / mass;
  const auto about = [&](const Part& p) {
    const model::Vec3 d = p.com - com;
    return p.inertia(1, 1) + p.mass * (d.x() * d.x() + d.z() * d.z());
  };
  const double pitch = about(whole) + sign * about(part);
  whole.mass = mass;
  whole.com = com;
  whole.inertia(1, 1) = pitch;
}

}  // namespace

Part composite(const model::SpatialTree& tree, int index) {
  const model::SpatialLink& link = tree.links[index];
  Part whole{link.mass, link.com, link.inertia};
  for (const model::SpatialJoint& joint : tree.joints) {
    if (joint.parent != index || joint.kind != model::SpatialJointKind::fixed) continue;
    Part below = composite(tree, joint.child);
    below.com = joint.origin + joint.rotation * below.com;
    merge(whole, below, 1.0);
  }
  return whole;
}

Part own_share(const model::SpatialTree& tree, int index, Part whole) {
  for (const model::SpatialJoint& joint : tree.joints) {
    if (joint.parent != index || joint.kind != model::SpatialJointKind::fixed) continue;
    Part below = composite(tree, joint.child);
    below.com = joint.origin + joint.rotation * below.com;
    merge(whole, below, -1.0);
  }
  // MuJoCo wants inertias that a body can have about every axis.
  whole.inertia =
      model::Vec3(whole.inertia(1, 1), whole.inertia(1, 1), 0.5 * whole.inertia(1, 1)).asDiagonal();
  return whole;
}

}  // namespace jaculus::testbed
