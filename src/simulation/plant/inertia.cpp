#include "simulation/plant/inertia.h"

#include <cmath>

namespace jaculus::simulation::detail {

bool Inertia::set(const Mechanism& mechanism) {
  size_ = mechanism.n;
  mechanism.assemble(factor_.data(), bias_.data());

  for (int j = 0; j < size_; ++j) {
    double* own = &factor_[j * kMaxSize];
    for (int k = 0; k < j; ++k) {
      const double* other = column(k);
      const double factor = other[j];
      for (int i = j; i < size_; ++i) own[i] -= factor * other[i];
    }
    if (!(own[j] > 0.0)) return false;

    const double inverse = 1.0 / std::sqrt(own[j]);
    inverse_diagonal_[j] = inverse;
    for (int i = j; i < size_; ++i) own[i] *= inverse;
  }
  return true;
}

double Inertia::diagonal(int i) const {
  double sum = 0.0;
  for (int j = 0; j <= i; ++j) sum += column(j)[i] * column(j)[i];
  return sum;
}

void Inertia::forward(double* x) const {
  for (int j = 0; j < size_; ++j) {
    const double* own = column(j);
    const double value = x[j] *= inverse_diagonal_[j];
    for (int i = j + 1; i < size_; ++i) x[i] -= own[i] * value;
  }
}

void Inertia::backward(double* x) const {
  for (int j = size_ - 1; j >= 0; --j) {
    const double* own = column(j);
    double sum = x[j];
    for (int i = j + 1; i < size_; ++i) sum -= own[i] * x[i];
    x[j] = sum * inverse_diagonal_[j];
  }
}

}  // namespace jaculus::simulation::detail
