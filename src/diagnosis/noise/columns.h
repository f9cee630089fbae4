#pragma once
// White columns with their products, put side by side or added without another pass over the rows
// of the random effects: that pass costs a hundred times what the columns' own products do. Some
// hundred columns of a leap's rows are larger than what a processor keeps at hand, so that a
// product with one more column, or a copy, waits for memory: products are taken with many columns
// at once, and what needs products alone copies no rows.

#include "diagnosis/noise/random_effects.h"

namespace jaculus::diagnosis {

struct Columns {
  Matrix X;           ///< rows x n
  Products products;  ///< of X
};

Columns columns_of(const RandomEffects& effects, Matrix X);

/// A^T B, of all rows and of each misfit's: products of two sets of columns with one another.
struct Across {
  Matrix gram;                  ///< columns of A x columns of B
  std::vector<Matrix> misfits;  ///< a misfit each

  /// Those of some columns of B; and with those of more columns behind it.
  [[nodiscard]] Across of(Eigen::Index first, Eigen::Index count) const;
  [[nodiscard]] Across with(const Across& more) const;
};
Across products_between(const RandomEffects& effects, ConstMatrixRef A, ConstMatrixRef B);

/// Products of [A B].
Products side_by_side(const Products& a, const Across& across, const Products& b);
/// [A B].
Columns side_by_side(const RandomEffects& effects, const Columns& a, const Columns& b);

/// Products of A with the one column of B added to its first.
Products first_moved(const Products& a, const Across& across, const Products& b);

}  // namespace jaculus::diagnosis
