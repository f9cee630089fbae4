#pragma once
// What intervals of a fit's parameters stand on: deviations of misfits that parameters were fitted
// to are too small, and as uncertain as the few values that tell them.
//
// Of a coordinate under a plan n values tell the variance v of its misfit (random_effects.h).
// A fit has the most likely v; with what the parameters took added, as restricted likelihood has it
// (Patterson and Thompson 1971),
//   v_c = 1 + (E_c + tr(H^-1 J_c^T J_c) - N_c)/n_c,  H = sum_c J_c^T J_c/v_c + I + (rows of no
//   misfit),
// to its fixed point: (E_c - N_c + n_c)/(n_c - told_c), told_c = tr(H^-1 J_c^T J_c)/v_c. Never less
// than its least, where nothing was estimated.
// A sum a^T u has the variance V = a^T H^-1 a and Student's quantile, of
//   nu = V^2/sum_c (V_c^2/(n_c - told_c)),  V_c = |J_c H^-1 a|^2/v_c,
// degrees of freedom over the coordinates whose misfit was estimated (Satterthwaite 1946).

#include <vector>

#include "diagnosis/selection/fit.h"

namespace jaculus::diagnosis {

struct IntervalBasis {
  /// A coordinate whose misfit was estimated.
  struct Coordinate {
    Matrix information;    ///< J_c^T J_c/v_c
    double freedom = 0.0;  ///< n_c - told_c, at least 1
  };

  Vector scales;      ///< deviations of the random effects
  Matrix covariance;  ///< H^-1, of u
  std::vector<Coordinate> coordinates;

  /// Deviation of a^T u.
  [[nodiscard]] double deviation(const Vector& a) const;
  /// Of |a^T u|/deviation, of 95 %.
  [[nodiscard]] double quantile(const Vector& a) const;
};

/// Where no misfit was estimated: the fit's own deviations and covariance, the normal's quantile.
IntervalBasis interval_basis(const Whitening& whitening, const Fit& fit);

}  // namespace jaculus::diagnosis
