#include "simulation/contact/contact_rows.h"

#include <cassert>

namespace jaculus::simulation::detail {

void ContactRows::set(const Inertia& inertia, const std::vector<ContactState>& contacts,
                      const std::vector<int>& touching) {
  assert(count_of(touching) <= kMaxTouching);
  size_ = inertia.size();
  touching_ = touching;
  const int count = count_of(touching);
  for (int j = 0; j < size_; ++j) {
    double* x = &solved_[j * kStride];
    for (int k = 0; k < count; ++k) {
      const ContactState& c = contacts[touching[k]];
      x[2 * k] = c.tangential[j];
      x[2 * k + 1] = c.normal[j];
    }
  }

  if (count <= 2)
    solve<4>(inertia);
  else if (count == 3)
    solve<6>(inertia);
  else if (count == 4)
    solve<8>(inertia);
  else
    solve<kStride>(inertia);
}

/// solved_ = L^-1 of what it holds, A = solved_^T solved_, of its first kRows columns side by side.
template <int kRows>
void ContactRows::solve(const Inertia& inertia) {
  const int used = 2 * count_of(touching_);
  for (int j = 0; j < size_; ++j)
    for (int r = used; r < kRows; ++r) solved_[j * kStride + r] = 0.0;

  double A[kRows * kRows] = {};
  for (int j = 0; j < size_; ++j) {
    double* x = &solved_[j * kStride];
    const double* column = inertia.column(j);
    for (int r = 0; r < kRows; ++r) x[r] *= inertia.inverse_diagonal(j);
    for (int i = j + 1; i < size_; ++i) {
      double* y = &solved_[i * kStride];
      for (int r = 0; r < kRows; ++r) y[r] -= column[i] * x[r];
    }
    for (int c = 0; c < kRows; ++c)
      for (int r = 0; r < kRows; ++r) A[c * kRows + r] += x[c] * x[r];
  }

  for (int c = 0; c < used; ++c)
    for (int r = 0; r < used; ++r) A_[c * kStride + r] = A[c * kRows + r];
}

void ContactRows::set_system(const std::vector<Unilateral>& unilaterals,
                             ContactSystem& system) const {
  system.count = count_of(touching_);
  system.A = A_.data();
  for (int k = 0; k < system.count; ++k) {
    system.mu[k] = unilaterals[touching_[k]].mu;
    system.target[k] = 0.0;
    system.moving[k] = false;
    system.direction[k] = 0.0;
  }
  system.scale_force = system.scale_w = 1.0;
}

void ContactRows::add_product(const double* x, double* out) const {
  const int rows = 2 * count_of(touching_);
  for (int j = 0; j < size_; ++j)
    for (int r = 0; r < rows; ++r) out[r] += solved_[j * kStride + r] * x[j];
}

void ContactRows::add_transposed(const double* lambda, double* x) const {
  for (int k = 0; k < count_of(touching_); ++k) {
    const double* row = &solved_[2 * k];
    for (int j = 0; j < size_; ++j)
      x[j] += lambda[2 * k] * row[j * kStride] + lambda[2 * k + 1] * row[j * kStride + 1];
  }
}

void ContactRows::add_response(const Inertia& inertia, const double* lambda, double* x) const {
  double sum[kMaxSize] = {};
  add_transposed(lambda, sum);
  inertia.backward(sum);
  for (int i = 0; i < size_; ++i) x[i] += sum[i];
}

}  // namespace jaculus::simulation::detail
