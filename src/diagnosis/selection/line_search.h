#pragma once
// Line search of screening: how far along its first parameter an effect helps, beyond the reach of
// slopes.
//
// Strong effects leave the reach of slopes (a tail that rebounds, air that no longer brakes), so
// the first parameter also takes the steps u = its probing step times 1/8, 1/4, ... 8, both ways,
// or 16 even spaces where its bounds are closer than that; and then, a few times, the middle of the
// wider space beside the best step. With the base model's parameters moved
// linearly,
//   score(u) = log evidence there - u^2/2 - log(1 + |(r(u) - r)/u|^2)/2,
// the last norm by V^-1, the deviations of the random effects following at every step.
// Effects with a threshold (slip, limits) do nothing up to it and soon too much: where what a step
// changes is far beyond the proportion of the step before, and does harm, the space between the two
// is halved until a step helps.

#include "diagnosis/noise/columns.h"
#include "diagnosis/selection/fit.h"

namespace jaculus::diagnosis {

/// White columns X = [r Y] by deviations of the random effects that follow them, at most `steps`
/// from `scales`: to be compared by evidence().
ScaleEstimate followed_by(const Problem& problem, const RandomEffects& random,
                          const Products& products, const Vector& scales, int steps);

/// A base model as screening sees it: [r0 -J], and its log evidence by such deviations.
struct Standing {
  Columns model;
  double log_evidence = 0.0;
};
Standing standing_of(const Problem& problem, const Whitening& whitening, const Fit& base);

/// Probing step of a parameter from `value`, times `share`; inwards where it would leave the
/// bounds.
double probe_step(const FreeParameter& parameter, double value, double share);

/// The best step of a line search.
struct BestStep {
  double u = kNaN;       ///< prior scales; NaN: none beats standing still
  double score = 0.0;    ///< log evidence gained
  long predictions = 0;  ///< sets of simulations that it took
};
/// Searches along parameter `first` from the base model.
BestStep line_search(const Problem& problem, const Whitening& whitening, const Fit& base,
                     const Standing& standing, int first);

}  // namespace jaculus::diagnosis
