#pragma once
// What a model lacks, as forces along the robot's coordinates and as misfits.
//
// Under a logged input forces are part of the model that was fitted (noise/random_effects.h). Under
// a plan it has misfits of any form; which forces would do the same is asked afterwards, of the
// fit as it is:
//   r = G w + e,   w ~ N(0, s_g^2) constant over boxes of time, a group a coordinate,  e ~ N(0, I)
// with the deviations s of most evidence. It describes what is left and decides nothing.

#include <vector>

#include "diagnosis/selection/fit.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// Along every coordinate of which the data tell something, and the misfit of each.
std::vector<LackingForce> lacking_forces(const Problem& problem, const Whitening& whitening,
                                         const Fit& fit);

}  // namespace jaculus::diagnosis
