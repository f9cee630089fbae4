#include "simulation/plant/inertia.h"

#include <cmath>
#include <utility>

namespace jaculus::simulation::detail {

namespace {

// Loops of a size that the compiler knows are straight code, which takes half the time; robots are
// small.
constexpr int kUnrolled = 12;

/// M = L L^T in place, lower triangle; inverse: 1/L_jj. False where M is not positive definite.
template <int kSize>
bool factorise(double* L, double* inverse, int given) {
  const int size = kSize > 0 ? kSize : given;
#pragma GCC unroll kUnrolled
  for (int j = 0; j < size; ++j) {
    double* own = L + j * kMaxSize;
#pragma GCC unroll kUnrolled
    for (int k = 0; k < j; ++k) {
      const double* other = L + k * kMaxSize;
      const double factor = other[j];
#pragma GCC unroll kUnrolled
      for (int i = j; i < size; ++i) own[i] -= factor * other[i];
    }
    if (!(own[j] > 0.0)) return false;

    const double reciprocal = inverse[j] = 1.0 / std::sqrt(own[j]);
#pragma GCC unroll kUnrolled
    for (int i = j; i < size; ++i) own[i] *= reciprocal;
  }
  return true;
}

template <int kSize>
void solve_forward(const double* L, const double* inverse, double* x, int given) {
  const int size = kSize > 0 ? kSize : given;
#pragma GCC unroll kUnrolled
  for (int j = 0; j < size; ++j) {
    const double* own = L + j * kMaxSize;
    const double value = x[j] *= inverse[j];
#pragma GCC unroll kUnrolled
    for (int i = j + 1; i < size; ++i) x[i] -= own[i] * value;
  }
}

template <int kSize>
void solve_backward(const double* L, const double* inverse, double* x, int given) {
  const int size = kSize > 0 ? kSize : given;
#pragma GCC unroll kUnrolled
  for (int j = size - 1; j >= 0; --j) {
    const double* own = L + j * kMaxSize;
    double sum = x[j];
#pragma GCC unroll kUnrolled
    for (int i = j + 1; i < size; ++i) sum -= own[i] * x[i];
    x[j] = sum * inverse[j];
  }
}

template <int... kSizes>
InertiaKernels kernels_of(int size, std::integer_sequence<int, kSizes...>) {
  static constexpr InertiaKernels all[] = {
      {factorise<kSizes>, solve_forward<kSizes>, solve_backward<kSizes>}...};
  return all[size <= kUnrolled ? size : 0];
}

}  // namespace

bool Inertia::set(const Mechanism& mechanism) {
  if (size_ != mechanism.n || kernels_.factorise == nullptr) {
    size_ = mechanism.n;
    kernels_ = kernels_of(size_, std::make_integer_sequence<int, kUnrolled + 1>());
  }
  mechanism.assemble(factor_.data(), bias_.data());
  return kernels_.factorise(factor_.data(), inverse_diagonal_.data(), size_);
}

double Inertia::diagonal(int i) const {
  double sum = 0.0;
  for (int j = 0; j <= i; ++j) sum += column(j)[i] * column(j)[i];
  return sum;
}

void Inertia::forward(double* x) const {
  kernels_.forward(factor_.data(), inverse_diagonal_.data(), x, size_);
}

void Inertia::backward(double* x) const {
  kernels_.backward(factor_.data(), inverse_diagonal_.data(), x, size_);
}

}  // namespace jaculus::simulation::detail
