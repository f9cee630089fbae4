#pragma once
// Directions along which parameters move the data by more than noise, of slopes T by each of them
// in prior scales, which may have changed by a share e of each since they were told:
//   T^T T + e^2 diag(|T_i|^2) = V L V^T,   those columns of V whose sqrt(L) is large.
// Parameters that do the same share one direction. What is orthogonal to all of them moves the rows
// by less, also where it is the difference of strong slopes, each of which changed by so much.

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

struct StrongDirections {
  Matrix along;  ///< V: parameters x directions, orthonormal
  /// How far all rows move by a prior scale along each, |T v|, or would by the slopes of single
  /// parameters if none cancelled, the root of sum |T_i|^2 v_i^2, if that is more: by the larger a
  /// difference is as exact as theirs are [noise deviations]
  Vector sizes;
};

/// Those of a sqrt(L) beyond `least`, the largest last; T white rows x parameters, `changed`: e.
StrongDirections strong_directions(const Matrix& slopes, double least, double changed);

/// T + (D - T V) V^T: slopes T as they were but along the directions V, along which they are D.
Matrix told_along(const Matrix& slopes, const Matrix& along, const Matrix& told);

}  // namespace jaculus::diagnosis
