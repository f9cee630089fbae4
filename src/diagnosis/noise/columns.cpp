#include "diagnosis/noise/columns.h"

namespace jaculus::diagnosis {
namespace {

Matrix joined(const Matrix& a, const Matrix& b) {
  Matrix both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

/// A^T B, of all rows and of each misfit's.
Products products_between(const RandomEffects& effects, const Matrix& A, const Matrix& B) {
  Products out{Matrix::Zero(A.cols(), B.cols()), {}, {}};
  for (const Misfit& misfit : effects.misfits) {
    out.misfits.emplace_back(Matrix::Zero(A.cols(), B.cols()));
    for (const auto& [first, count] : misfit.spans)
      out.misfits.back().noalias() +=
          A.middleRows(first, count).transpose() * B.middleRows(first, count);
    out.gram += out.misfits.back();
  }
  if (effects.misfits.empty()) {
    out.gram = A.transpose() * B;
    return out;
  }
  for (const auto& [first, count] : effects.plain)
    out.gram.noalias() += A.middleRows(first, count).transpose() * B.middleRows(first, count);
  for (const RandomBlock& block : effects.blocks)
    out.gram.noalias() +=
        A.middleRows(block.first, block.count).transpose() * B.middleRows(block.first, block.count);
  return out;
}

Matrix bordered(const Matrix& a, const Matrix& across, const Matrix& b) {
  Matrix both(a.rows() + b.rows(), a.cols() + b.cols());
  both << a, across, across.transpose(), b;
  return both;
}

/// Products of columns of which the first has one more added to it.
void add_to_first(Matrix& gram, const Matrix& across, const Matrix& moved) {
  gram.col(0) += across.col(0);
  gram.row(0) += across.col(0).transpose();
  gram(0, 0) += moved(0, 0);
}

}  // namespace

Columns columns_of(const RandomEffects& effects, Matrix X) {
  Products products = products_of(effects, X);
  return {std::move(X), std::move(products)};
}

Columns side_by_side(const RandomEffects& effects, const Columns& a, const Columns& b) {
  const Products across = products_between(effects, a.X, b.X);
  Columns both{joined(a.X, b.X), {}};
  both.products.shared = a.products.shared;
  both.products.gram = bordered(a.products.gram, across.gram, b.products.gram);
  for (std::size_t c = 0; c < a.products.misfits.size(); ++c)
    both.products.misfits.push_back(
        bordered(a.products.misfits[c], across.misfits[c], b.products.misfits[c]));
  for (std::size_t i = 0; i < a.products.blocks.size(); ++i)
    both.products.blocks.push_back(joined(a.products.blocks[i], b.products.blocks[i]));
  return both;
}

Columns first_moved(const RandomEffects& effects, const Columns& a, const Columns& moved) {
  const Products across = products_between(effects, a.X, moved.X);
  Columns out = a;
  out.X.col(0) += moved.X.col(0);
  add_to_first(out.products.gram, across.gram, moved.products.gram);
  for (std::size_t c = 0; c < out.products.misfits.size(); ++c)
    add_to_first(out.products.misfits[c], across.misfits[c], moved.products.misfits[c]);
  for (std::size_t i = 0; i < out.products.blocks.size(); ++i)
    out.products.blocks[i].col(0) += moved.products.blocks[i].col(0);
  return out;
}

}  // namespace jaculus::diagnosis
