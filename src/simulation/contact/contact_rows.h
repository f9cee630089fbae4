#pragma once
// The rows J of contacts that touch, as L^-1 J^T with M = L L^T, and Delassus' matrix of them,
// A = J M^-1 J^T.

#include <array>
#include <vector>

#include "simulation/contact/contact_law.h"
#include "simulation/contact/contacts.h"
#include "simulation/plant/inertia.h"

namespace jaculus::simulation::detail {

class ContactRows {
 public:
  /// Rows of `touching`, kMaxTouching at most, indices of `contacts`.
  void set(const Inertia& inertia, const std::vector<ContactState>& contacts,
           const std::vector<int>& touching);

  [[nodiscard]] const std::vector<int>& touching() const { return touching_; }
  /// Their contact system, with A alone and no demand on any row.
  void set_system(const std::vector<Unilateral>& unilaterals, ContactSystem& system) const;
  /// out += (L^-1 J^T)^T x, 2 values a contact; x as forward() leaves it.
  void add_product(const double* x, double* out) const;
  /// x += L^-1 J^T lambda
  void add_transposed(const double* lambda, double* x) const;
  /// x += M^-1 J^T lambda
  void add_response(const Inertia& inertia, const double* lambda, double* x) const;

 private:
  template <int kRows>
  void solve(const Inertia& inertia);

  int size_ = 0;  ///< coordinates
  std::vector<int> touching_;
  std::array<double, kMaxSize * kStride> solved_;  ///< L^-1 J^T, row by row: n x kStride
  std::array<double, kStride * kStride> A_;        ///< column by column
};

}  // namespace jaculus::simulation::detail
