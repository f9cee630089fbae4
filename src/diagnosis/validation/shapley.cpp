#include "diagnosis/validation/shapley.h"

#include <cmath>

namespace jaculus::diagnosis {

Vector shapley_values(const std::vector<double>& v, int n) {
  std::vector<double> weight(n);  // of a subset of this size without the player
  for (int size = 0; size < n; ++size)
    weight[size] = std::exp(std::lgamma(size + 1.0) + std::lgamma(n - size) - std::lgamma(n + 1.0));

  Vector value = Vector::Zero(n);
  for (unsigned subset = 0; subset < v.size(); ++subset) {
    const int size = __builtin_popcount(subset);
    for (int k = 0; k < n; ++k)
      if ((subset >> k & 1U) == 0U) value[k] += weight[size] * (v[subset | 1U << k] - v[subset]);
  }
  return value;
}

}  // namespace jaculus::diagnosis
