#pragma once
// Which part of a robot a motor, a link or a toe belongs to, by its files alone:
//   tail         what a link with drag hangs on or carries
//   front, rear  the chain of a foot, and chains that a pin closes with it; front is the foot whose
//                chain leaves the base at the larger x (feet under one hip are rear ones)
//   other        all the rest (a pendulum's joint)

#include <string>
#include <vector>

#include "jaculus/model/urdf.h"

namespace jaculus::testbed {

enum class Limb { tail, front_leg, rear_leg, other };

/// A pin between two links in space: one side of a leg.
struct Pin {
  std::string link_a, link_b;
  model::Vec3 point_a, point_b;  ///< in the links' frames [m]
  std::string joint_a, joint_b;  ///< the joints that follow from it
  /// side on which the pin lies: sign of (b - a) x (pin - a) in the sagittal plane
  double branch = 1.0;
};

/// A toe of one leg.
struct Toe {
  std::string name;   ///< of the planar foot
  std::string link;   ///< in space
  model::Vec3 point;  ///< [m]
  Limb limb = Limb::other;
};

/// Limb of every link; `other` for the base and what is fixed to it.
std::vector<Limb> limbs_of_links(const model::SpatialTree& tree,
                                 const std::vector<std::string>& drag_links,
                                 const std::vector<Toe>& toes, const std::vector<Pin>& pins);

/// Joint that moves a link: its own, or, where that is fixed, the next above; -1: none.
int moving_joint(const model::SpatialTree& tree, int link);

}  // namespace jaculus::testbed
