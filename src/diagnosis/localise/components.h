#pragma once
// Shares of the gap by component, from the posterior of selection.
//
// In a model of effects M the gap's energy is |r_none|^2 - N, r whitened residuals of N rows.
// Players are the effects of M, one that acts in several components at once (all legs) being a
// player in each. A player's energy is its Shapley value of v(S) = |r()|^2 - |r(S)|^2, r(S) the
// residual with the players S alone at their fitted values; what the model leaves beyond noise,
// |r_M|^2 - N less 1.645 deviations, is unexplained.
// A component's share is the mean over models by their posterior probability of its players' energy
// over explained + unexplained. Intervals: draws of a model by its probability and of its
// parameters by their covariance, with signatures proportional to the first parameter.

#include "diagnosis/forward/plant_forward.h"
#include "diagnosis/selection/search.h"
#include "jaculus/diagnosis/localisation.h"

namespace jaculus::diagnosis {

struct ComponentShares {
  std::vector<ComponentShare> components;  ///< all of them, in the enum's order
  double unexplained = 0.0;                ///< share of the gap's energy [-]
};
ComponentShares component_shares(const Problem& problem, const Selection& selection,
                                 const Posterior& posterior);

}  // namespace jaculus::diagnosis
