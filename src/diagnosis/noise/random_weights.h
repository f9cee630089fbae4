#pragma once
// V^-1 on white rows, V = I + G S^2 G^T on blocks and 1 + m on misfits (random_effects.h), without
// a root of V. Rows of a misfit are divided by the root of 1 + m. In blocks
//
// The most probable forces behind a vector x,
//   w = argmin |x - G w|^2 + |S^-1 w|^2,
// are linear in x, and what is left at them is x^T V^-1 x (Rasmussen and Williams 2006, section
// 2.7). So
//   M x = [x - G w;  S^-1 w],   (M x)^T (M y) = x^T V^-1 y,   V^-1 x = x - G w,
// at the price of one factor of I + S G^T G S a block, where a root of V^-1 would take its
// eigenvectors in all rows.

#include <Eigen/Cholesky>

#include "diagnosis/noise/random_effects.h"

namespace jaculus::diagnosis {

class RandomWeights {
 public:
  RandomWeights(const RandomEffects& effects, const Vector& scales);

  /// How many rows more than X has M X.
  [[nodiscard]] Eigen::Index more_rows() const { return forces_; }
  /// M X, a column each.
  [[nodiscard]] Matrix stacked(const Matrix& X) const;
  /// V^-1 X, a column each.
  [[nodiscard]] Matrix inverse(const Matrix& X) const;

 private:
  struct Block {
    int first = 0, count = 0;  ///< white rows
    Matrix columns;            ///< G S, without those whose deviation is zero
    Eigen::LLT<Matrix> inner;  ///< of I + S G^T G S
  };

  struct Rows {
    int first = 0, count = 0;  ///< white rows
    double root = 1.0;         ///< 1/sqrt(1 + m)
  };

  std::vector<Block> blocks_;
  std::vector<Rows> rows_;
  Eigen::Index forces_ = 0;
};

}  // namespace jaculus::diagnosis
