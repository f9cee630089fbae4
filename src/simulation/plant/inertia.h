#pragma once
// The mass matrix where a mechanism stands, M = L L^T (Cholesky), and the bias force h.

#include <array>

#include "simulation/plant/mechanism.h"

namespace jaculus::simulation::detail {

/// Factor and solves for one number of coordinates that the compiler knows, or for any.
struct InertiaKernels {
  bool (*factorise)(double* L, double* inverse, int size) = nullptr;
  void (*forward)(const double* L, const double* inverse, double* x, int size) = nullptr;
  void (*backward)(const double* L, const double* inverse, double* x, int size) = nullptr;
};

class Inertia {
 public:
  /// Takes them from a mechanism that is set. False where M is not positive definite.
  bool set(const Mechanism& mechanism);

  [[nodiscard]] int size() const { return size_; }
  /// Bias force of a coordinate [N or N m].
  [[nodiscard]] double bias(int i) const { return bias_[i]; }
  /// M_ii.
  [[nodiscard]] double diagonal(int i) const;
  /// x = L^-1 x
  void forward(double* x) const;
  /// x = L^-T x
  void backward(double* x) const;
  /// Column j of L, from its row j on in use.
  [[nodiscard]] const double* column(int j) const { return &factor_[j * kMaxSize]; }
  /// 1/L_jj
  [[nodiscard]] double inverse_diagonal(int j) const { return inverse_diagonal_[j]; }

 private:
  int size_ = 0;
  InertiaKernels kernels_;
  std::array<double, kMaxSize * kMaxSize> factor_;  ///< L, column by column
  std::array<double, kMaxSize> bias_, inverse_diagonal_;
};

}  // namespace jaculus::simulation::detail
