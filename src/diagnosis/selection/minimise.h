#pragma once
// Minimises a fit's cost for given deviations of the random effects, by Ceres (Levenberg-Marquardt
// with bounds).
//
//   c(u) = |M r|^2/2 + |u|^2/2  (M: noise/random_weights.h),  g = (M J)^T M r + u,
//   H = (M J)^T M J + I = R^T R
// Ceres asks for residuals, but needs their cost, gradient and Gauss-Newton matrix alone. So it is
// given as many rows as there are parameters and one,
//   [R^-T g;  (2 c - |R^-T g|^2)^1/2]  with the Jacobian  [R; 0],
// which have all three, in place of ten thousand. Misfits are on the way at their most
// likely for r (random_effects.h): with their log det in c, the gradient is unchanged, for c is
// least by them, and H takes them as they are.

#include <optional>

#include "diagnosis/noise/random_effects.h"
#include "diagnosis/selection/residual.h"

namespace jaculus::diagnosis {

enum class Misfits { held, follow };

/// c(u) of a residual, with the log det of its misfits where these follow.
double cost_of(const RandomEffects& random, const Vector& scales, Misfits misfits, const Vector& r,
               const Vector& u);

/// From u on, which is left at the best point met. By how much the cost fell; nothing where no
/// point could be evaluated.
std::optional<double> minimise(Residual& residual, const RandomEffects& random,
                               const Vector& scales, Misfits misfits, int iterations, Vector& u);

}  // namespace jaculus::diagnosis
