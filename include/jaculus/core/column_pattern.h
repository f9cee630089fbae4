#pragma once
// Products with a matrix most of whose elements are zero by structure, as the maps between a
// robot's coordinates are: where its others stand is known once, their values are of any scalar
// (lanes.h). Sums go from left to right.

#include <vector>

#include "jaculus/core/lanes.h"

namespace jaculus {

/// Rows of the elements that may differ from zero, column by column.
struct ColumnPattern {
  std::vector<std::vector<int>> rows;

  /// Of the elements of a matrix that are not zero.
  static ColumnPattern of(const Matrix& matrix);
};

/// C += sign * A S. S is of any type that is indexed by row and column.
template <class S, class Sparse>
void add_times_sparse(const std::type_identity_t<ConstRefOf<S>>& A, const Sparse& sparse,
                      const ColumnPattern& pattern, double sign, std::type_identity_t<RefOf<S>> C);
/// C += sign * S^T B.
template <class S, class Sparse>
void add_sparse_transposed_times(const Sparse& sparse, const ColumnPattern& pattern, double sign,
                                 const std::type_identity_t<ConstRefOf<S>>& B,
                                 std::type_identity_t<RefOf<S>> C);
/// C += sign * S B.
template <class S, class Sparse>
void add_sparse_times(const Sparse& sparse, const ColumnPattern& pattern, double sign,
                      const std::type_identity_t<ConstRefOf<S>>& B,
                      std::type_identity_t<RefOf<S>> C);

}  // namespace jaculus
