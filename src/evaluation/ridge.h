#pragma once
// Ridge regression on a linear model whose parameters have bounds.
//   u = argmin |r - G u|^2 + lambda |u|^2,   lower <= u <= upper,
// by cyclic coordinate descent; lambda of least error on held-out rows, a fifth of them in one
// piece at a time. Source: Hoerl and Kennard, Technometrics 12 (1970).

#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::evaluation {

struct RidgeFit {
  Vector u;
  double lambda = kNaN;
};

/// G: rows x parameters, r: rows, a range each.
RidgeFit ridge(const Matrix& G, const Vector& r, const std::vector<Bounds>& ranges);

}  // namespace jaculus::evaluation
