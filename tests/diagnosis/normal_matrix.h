#pragma once
// Independent standard normal numbers, the same for the same seed.

#include <random>

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

inline Matrix normal_matrix(Eigen::Index rows, Eigen::Index cols, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(rows, cols,
                             [&](Eigen::Index, Eigen::Index) { return normal(generator); });
}

}  // namespace jaculus::diagnosis
