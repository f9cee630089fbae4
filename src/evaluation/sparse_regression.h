#pragma once
// Sequentially thresholded least squares: fit, drop the terms whose coefficient is small, fit the
// rest, until none is dropped. Columns and data are scaled to a mean square of one, so that a
// coefficient is a share of the data's size; a weight of 0.001 on its square keeps columns that
// look alike from cancelling each other. The threshold is the largest whose error on held-out rows,
// a fifth of them in one piece at a time, is within a standard error of the least. Source: Brunton,
// Proctor and Kutz, PNAS 113 (2016), 10.1073/pnas.1517384113.

#include "jaculus/core/types.h"

namespace jaculus::evaluation {

struct SparseFit {
  Vector coefficients;  ///< in the units of the data; 0 where the term was dropped
  /// of scaled coefficients; infinite: no term does better on held-out rows than none
  double threshold = kInfinity;
};

/// library: rows x terms, data: rows. A column of zeros is never used.
SparseFit sparse_regression(const Matrix& library, const Vector& data);

}  // namespace jaculus::evaluation
