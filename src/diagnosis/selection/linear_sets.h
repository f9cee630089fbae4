#pragma once
// Sets of effects by linear algebra alone: what many sets near a fitted one could explain, from
// the columns that screening about it left behind.
//
// A set that leads may stand in for another that is at work, and none of the sets that differ from
// it by one member need be that; so sets two members larger are judged too. About a fitted set,
// with r0 what is left of the data at u = 0 by its slopes, every other set is the linear Gaussian
// model
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
  Vector mean;    ///< of u of the members' parameters, in their order
  Vector p;       ///< all parameters there, nuisances too, within bounds
  Vector scales;  ///< deviations S that it needs
};

/// Evidence of sets about the fit of the candidates `about`, best first, of the foremost of them
/// (foremost_sets.h); without those of which a member has no columns, or an
/// estimate on the wrong side of a boundary: what is left without it is a set of its own.
std::vector<LinearSet> linear_sets(const Problem& problem, const Whitening& whitening,
                                   const Fit& fit, const std::vector<int>& about,
                                   const std::vector<Probe>& probes,
                                   std::vector<std::vector<int>> sets);

}  // namespace jaculus::diagnosis
