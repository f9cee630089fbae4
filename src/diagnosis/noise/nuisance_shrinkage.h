#pragma once
// M^-1/2 of a segment's nuisances, M = I + A A^T, without vectors as long as its rows:
//   A^T A = V diag(s^2) V^T,   M^-1/2 = I - A C A^T,   C = V diag(g/s^2) V^T,
//   g = 1 - 1/sqrt(1 + s^2), or 1 for directions that are taken off altogether,
// which is I - U diag(g) U^T of U = A V diag(1/s). A hundred nuisances are modes of one channel
// each, so that A is mostly zero where U is not: a product with A by the rows of each channel costs
// a seventh. g/s^2 is at most 1/2, or 1/s^2 of a large s: nothing is lost to rounding.

#include <utility>
#include <vector>

#include "diagnosis/noise/random_effects.h"

namespace jaculus::diagnosis {

class NuisanceShrinkage {
 public:
  NuisanceShrinkage() = default;
  /// A, white rows x nuisances, each already scaled by its prior; `spans`: first and count of the
  /// rows of each channel, which together are all. Directions of s at least `apart` are taken off.
  NuisanceShrinkage(const Matrix& A, const std::vector<std::pair<int, int>>& spans, double apart);

  /// On each column of X.
  void apply(MatrixRef X) const;
  /// The directions that are taken off, as if they shrank like the others.
  [[nodiscard]] const Shrinkage& apart() const { return apart_; }

 private:
  /// The rows of a channel of those columns of A that are not zero there.
  struct Part {
    int first = 0, count = 0;
    std::vector<Eigen::Index> columns;
    Matrix A;
  };
  [[nodiscard]] Matrix gram(Eigen::Index columns) const;
  [[nodiscard]] Matrix times(ConstMatrixRef X) const;

  std::vector<Part> parts_;
  Matrix C_;
  Shrinkage apart_;
};

}  // namespace jaculus::diagnosis
