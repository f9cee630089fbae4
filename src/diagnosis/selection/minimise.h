#pragma once
// Minimises a fit's cost for given deviations of the random effects, by Gauss-Newton steps within
// bounds and a trust region that is a box too.
//
//   c(u) = |M r|^2/2 + |u|^2/2  (M: noise/random_weights.h),  g = (M J)^T M r + u,
//   H = (M J)^T M J + I
//   step d = argmin g.d + d.H d/2,  lower <= u + d <= upper,  s_i |d_i| <= trusted,
//   s_i^2 = H_ii at the start
// (box_step.h; the rules of the region: Nocedal and Wright 2006, algorithm 4.1). Bounds belong to
// the step itself, for most of a fit's parameters move the residual in proportion (tolerances by
// their slopes): to these no trust applies, and whatever an effect's one or two parameters do they
// take their best values within bounds at once. A step without bounds that is cut to them, as
// general solvers for least squares take it, needed thirty simulations an effect in place of five.
// Where a step keeps what its slopes promised these go on by a secant, effects' too, and are told
// by differences where one doesn't, and at the end: half of the simulations.
// Where slopes follow secants and steps fail twice in a row they say nothing any more (MINPACK):
// it ends unsettled, and a fit tells them anew.
//
// Misfits are on the way at their most likely for r (random_effects.h): with their log det in c,
// the gradient is unchanged, for c is least by them, and H takes them as they are.

#include <optional>

#include "diagnosis/noise/random_effects.h"
#include "diagnosis/selection/residual.h"

namespace jaculus::diagnosis {

enum class Misfits { held, follow };

/// c(u) of a residual, with the log det of its misfits where these follow.
double cost_of(const RandomEffects& random, const Vector& scales, Misfits misfits, const Vector& r,
               const Vector& u);

struct Minimised {
  double fell = 0.0;  ///< by how much the cost fell
  /// Whether no step promised more, by slopes that were told there or without a limit by trust;
  /// else steps ran out, or slopes said nothing any more.
  bool settled = false;
};
/// Where it stays.
struct Ending {
  int iterations = 1;  ///< at most
  /// Fall of the cost below which it stays if a step that trust does not limit promises no more; at
  /// least what settings.fit_cost_tolerance says [nats]
  double least_fall = 0.0;
};
/// From u on, which is left at the best point met. Nothing where no point could be evaluated.
std::optional<Minimised> minimise(Residual& residual, const RandomEffects& random,
                                  const Vector& scales, Misfits misfits, const Ending& ending,
                                  Vector& u);

}  // namespace jaculus::diagnosis
