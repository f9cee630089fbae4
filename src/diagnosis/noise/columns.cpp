#include "diagnosis/noise/columns.h"

namespace jaculus::diagnosis {
namespace {

Matrix joined(const Matrix& a, const Matrix& b) {
  Matrix both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
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

Across Across::of(Eigen::Index first, Eigen::Index count) const {
  Across some{gram.middleCols(first, count), {}};
  for (const Matrix& own : misfits) some.misfits.emplace_back(own.middleCols(first, count));
  return some;
}

Across Across::with(const Across& more) const {
  Across all{joined(gram, more.gram), {}};
  for (std::size_t c = 0; c < misfits.size(); ++c)
    all.misfits.emplace_back(joined(misfits[c], more.misfits[c]));
  return all;
}

Across products_between(const RandomEffects& effects, ConstMatrixRef A, ConstMatrixRef B) {
  Across out{Matrix::Zero(A.cols(), B.cols()), {}};
  for (const Misfit& misfit : effects.misfits) {
    out.misfits.emplace_back(Matrix::Zero(A.cols(), B.cols()));
    for (const auto& [first, count] : misfit.spans)
      out.misfits.back().noalias() +=
          A.middleRows(first, count).transpose() * B.middleRows(first, count);
    out.gram += out.misfits.back();
  }
  if (effects.misfits.empty()) {
    out.gram.noalias() = A.transpose() * B;
    return out;
  }
  for (const auto& [first, count] : effects.plain)
    out.gram.noalias() += A.middleRows(first, count).transpose() * B.middleRows(first, count);
  for (const RandomBlock& block : effects.blocks)
    out.gram.noalias() +=
        A.middleRows(block.first, block.count).transpose() * B.middleRows(block.first, block.count);
  return out;
}

Products side_by_side(const Products& a, const Across& across, const Products& b) {
  Products both;
  both.shared = a.shared;
  both.gram = bordered(a.gram, across.gram, b.gram);
  for (std::size_t c = 0; c < a.misfits.size(); ++c)
    both.misfits.push_back(bordered(a.misfits[c], across.misfits[c], b.misfits[c]));
  for (std::size_t i = 0; i < a.blocks.size(); ++i)
    both.blocks.push_back(joined(a.blocks[i], b.blocks[i]));
  return both;
}

Columns side_by_side(const RandomEffects& effects, const Columns& a, const Columns& b) {
  return {joined(a.X, b.X),
          side_by_side(a.products, products_between(effects, a.X, b.X), b.products)};
}

Products first_moved(const Products& a, const Across& across, const Products& b) {
  Products out = a;
  add_to_first(out.gram, across.gram, b.gram);
  for (std::size_t c = 0; c < out.misfits.size(); ++c)
    add_to_first(out.misfits[c], across.misfits[c], b.misfits[c]);
  for (std::size_t i = 0; i < out.blocks.size(); ++i) out.blocks[i].col(0) += b.blocks[i].col(0);
  return out;
}

}  // namespace jaculus::diagnosis
