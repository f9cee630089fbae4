#pragma once
// Most probable parameters near a fit by Gauss-Newton steps whose slopes are known already: one
// simulation a step, where new slopes take one for each parameter. Where rows change little (a fold
// without one trial, a profile next to the optimum) a step or two reach what new slopes would.

#include "diagnosis/noise/random_weights.h"
#include "diagnosis/noise/whitening.h"
#include "diagnosis/selection/fit.h"

namespace jaculus::diagnosis {

struct NearFit {
  bool valid = false;        ///< whether the start could be simulated
  Vector p;                  ///< all parameters, at the least cost met
  std::vector<Vector> rows;  ///< predicted there, a dataset each [units of the rows]
  double cost = kInfinity;   ///< r^T V^-1 r/2 + |u|^2/2 of the free ones there
};

/// From p on, at most `steps`, until the cost no longer falls. `slopes`: dr/du of the parameters
/// `free`, white rows x free.
NearFit fit_by_known_slopes(const Problem& problem, const Whitening& space,
                            const RandomWeights& weights, const std::vector<int>& free,
                            const Matrix& slopes, Vector p, int steps);

/// Where the quadratic model about a fit is least without some of its effects, all parameters: with
/// H = J^T V^-1 J + I and the gradient g of the fit, e the effects' places and o those of the other
/// free ones, in prior scales from nominal, from u_o the step within bounds that is least of
///   g_o^T d - (H_oe u_e)^T d + d^T H_oo d/2.
/// Tolerances do what slopes have them do in the effects' place.
Vector optimum_without(const Problem& problem, const Whitening& whitening, const Fit& fit,
                       const std::vector<int>& members);

}  // namespace jaculus::diagnosis
