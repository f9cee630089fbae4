#pragma once
// The two sides of a planar body, left and right, that move alike.

#include "jaculus/model/planar.h"
#include "model/assumptions.h"
#include "model/reduce.h"

namespace jaculus::model {

struct PairReading {
  const PairSpec& pair;
  int line = 0;  ///< of the left joint in the URDF
  Assumptions& assumptions;
};

struct Side {
  const PlanarBody& body;
  Bounds range;  ///< of its joint [rad or m]
};

/// Whether two sides can stand for one. They must turn at the same place of the plane: InputError
/// where that is off by more than what the builder's tolerances allow. Bodies that differ are
/// noted, for their sum is exact, as is what is off by less. Returns the range that both joints
/// have, as the left one counts: where the axes are opposite, the right angle is minus the left
/// one.
Bounds compare_sides(const PairReading& reading, const Side& left, const Side& right);

/// Adds the right side to the left one: masses, the common centre of mass, inertias about it.
void add_side(PlanarBody& left, const PlanarBody& right);

}  // namespace jaculus::model
