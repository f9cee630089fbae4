#include "diagnosis/noise/columns.h"

namespace jaculus::diagnosis {
namespace {

Matrix joined(const Matrix& a, const Matrix& b) {
  Matrix both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

}  // namespace

Columns columns_of(const RandomEffects& effects, Matrix X) {
  Products products = products_of(effects, X);
  return {std::move(X), std::move(products)};
}

Columns side_by_side(const Columns& a, const Columns& b) {
  const Matrix across = a.X.transpose() * b.X;
  Columns both{joined(a.X, b.X), {}};
  both.products.gram.resize(both.X.cols(), both.X.cols());
  both.products.gram << a.products.gram, across, across.transpose(), b.products.gram;
  for (std::size_t i = 0; i < a.products.blocks.size(); ++i)
    both.products.blocks.push_back(joined(a.products.blocks[i], b.products.blocks[i]));
  return both;
}

Columns first_moved(const Columns& a, const Columns& moved) {
  const Vector across = a.X.transpose() * moved.X.col(0);
  Columns out = a;
  out.X.col(0) += moved.X.col(0);
  out.products.gram.col(0) += across;
  out.products.gram.row(0) += across.transpose();
  out.products.gram(0, 0) += moved.products.gram(0, 0);
  for (std::size_t i = 0; i < out.products.blocks.size(); ++i)
    out.products.blocks[i].col(0) += moved.products.blocks[i].col(0);
  return out;
}

}  // namespace jaculus::diagnosis
