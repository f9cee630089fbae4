#pragma once
// From the spatial tree to planar bodies: fixed joints are merged, pairs lumped, everything is
// projected on the sagittal plane.
//
//   mass     m = sum m_i                      over the links that move together, left and right
//   com      c = sum m_i c_i / m              x and z; y is dropped
//   inertia  I = sum I_i,yy + m_i |c_i - c|^2 with I_i about the link's own centre of mass, along
//            the root's axes
//
// Valid where every moving joint turns about y or slides in x-z, so that links stay parallel to the
// sagittal plane. What leans out of it by at most 10 deg is projected, and said; joints on one
// axle that leans stay one (lean.cpp).

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/model/planar.h"
#include "jaculus/model/urdf.h"
#include "model/assumptions.h"

namespace jaculus::model {

/// Frames and axes that lean out of the plane by less are taken as in it: lengths are then off by
/// at most 1 - cos = 1.5 %, half of what a weighed mass is (tolerances.h).
inline constexpr double kLean = 10.0 * M_PI / 180.0;

/// Two spatial joints (or links) that are one planar one.
struct PairSpec {
  std::string name;
  std::string left;
  std::string right;
  yaml::Node node;  ///< its place in robot.yaml
};

/// Where a link sits on its planar body.
struct LinkPlace {
  int body = 0;
  bool in_plane = true;          ///< its x-z plane is the sagittal plane
  double angle = 0.0;            ///< to the body's frame [rad]
  Vec2 position = Vec2::Zero();  ///< of its origin in the body's frame [m]
};

struct Reduction {
  std::vector<PlanarBody> bodies;
  std::vector<Bounds> ranges;  ///< of each body's joint [rad or m]; infinite for the base
  std::map<std::string, LinkPlace> links;  ///< by spatial name, and by planar name where lumped
  std::vector<HeldJoint> held;             ///< joints that move in the file and don't in the plane
  std::vector<std::string> notes;
};

/// `joints`, `links`: the pairs. A joint out of the plane, a pair whose sides move apart:
/// InputError. A pair that differs otherwise, a moving body without mass: noted, or InputError
/// where `reading` is strict.
Reduction reduce(const SpatialTree& spatial, const std::vector<PairSpec>& joints,
                 const std::vector<PairSpec>& links, const std::vector<HeldJoint>& held,
                 Reading reading = Reading::lenient);

/// The tree with joints held: they are fixed there.
SpatialTree hold_joints(const SpatialTree& spatial, const std::vector<HeldJoint>& held);

/// The same robot with its leaning joints' origins moved along their axes: those of one axle to its
/// middle, those that hang on them into their plane. Links keep their axes, not their origins.
SpatialTree gather_leaning(SpatialTree tree);

/// A joint below which nothing has mass can't be simulated; it is held at zero. InputError where it
/// is in a pair.
void hold_massless(SpatialTree& tree, const std::vector<PairSpec>& pairs, Assumptions& assumptions);

}  // namespace jaculus::model
