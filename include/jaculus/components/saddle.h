#pragma once
// The linear system of accelerations and forces of the feet,
//     [ M  -J^T ] [a]   [r_1]        M = L L^T (n x n), positive definite,
//     [ J    0  ] [f] = [r_2]        J (m x n) of full rank,
// by Cholesky's method for M and for the feet's share of it: no pivots to choose, so that four
// systems go through the same arithmetic (S = Lanes).
//     B = L^-1 J^T,   L_s L_s^T = B^T B,   y = L^-1 r_1,
//     f = (L_s L_s^T)^-1 (r_2 - B^T y),    a = L^-T (y + B f).
// Of the transposed system [M J^T; -J 0] (a, k) = (r_1, r_2), k = -f of (r_1, -r_2).

#include "jaculus/core/lanes.h"

namespace jaculus::components {

template <class S>
class SaddleOf {
 public:
  SaddleOf(int n, int m);

  /// M's lower triangle and J. Where they are singular, solutions are not finite.
  void factorize(const MatrixOf<S>& M, const MatrixOf<S>& J);
  /// In place, (n + m) rows.
  void solve(RefOf<S> rhs) const;
  void solve_transposed(RefOf<S> rhs) const;

 private:
  MatrixOf<S> L_, B_, L_s_;  ///< of both L the diagonal is inverted
};

}  // namespace jaculus::components
