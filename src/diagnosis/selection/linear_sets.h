#pragma once
// Sets of effects by linear algebra alone: what every pair or triple could explain of the residual
// at none, from the columns that screening left behind.
//
// A single that leads may stand in for two that are at work, and none of its neighbours need be one
// of them; so sets are not only sought from what leads. Every set is the linear Gaussian model
//   r0 = sum_i Y_i u_i + N n + C c + G w + e
// (noise/random_effects.h; Y_i the columns of an effect, N the nuisances'), its evidence by the
// deviations that it needs. All products are taken once, a set's are picked out of them. No
// simulation.

#include <vector>

#include "diagnosis/selection/screen.h"

namespace jaculus::diagnosis {

struct LinearSet {
  std::vector<int> members;  ///< candidates, sorted
  double log_evidence = -kInfinity;
  Vector mean;  ///< of u of the members' parameters, in their order
};

/// Evidence of sets, best first; without those of which a member has no columns, or an estimate on
/// the wrong side of a boundary: what is left without it is a set of its own.
std::vector<LinearSet> linear_sets(const Problem& problem, const Whitening& whitening,
                                   const Fit& none, const std::vector<Probe>& probes,
                                   const std::vector<std::vector<int>>& sets);

}  // namespace jaculus::diagnosis
