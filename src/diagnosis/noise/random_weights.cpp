#include "diagnosis/noise/random_weights.h"

#include <cmath>

namespace jaculus::diagnosis {

RandomWeights::RandomWeights(const RandomEffects& effects, const Vector& scales) {
  for (const Misfit& own : effects.misfits) {
    const double variance = own.variance(scales[own.group]);
    if (variance == 1.0) continue;
    for (const auto& [first, count] : own.spans)
      rows_.push_back({first, count, 1.0 / std::sqrt(variance)});
  }
  for (const RandomBlock& own : effects.blocks) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = 0; k < own.columns.cols(); ++k)
      if (scales[own.group[k]] > 0.0) kept.push_back(k);
    Vector deviations(count_of(kept));
    for (int k = 0; k < count_of(kept); ++k) deviations[k] = scales[own.group[kept[k]]];
    const auto S = deviations.asDiagonal();

    Matrix inner = S * own.gram(kept, kept) * S;
    inner.diagonal().array() += 1.0;
    blocks_.push_back({own.first, own.count, own.columns(Eigen::all, kept) * S, inner.llt()});
    forces_ += deviations.size();
  }
}

Matrix RandomWeights::stacked(const Matrix& X) const {
  Matrix out(X.rows() + forces_, X.cols());
  out.topRows(X.rows()) = X;
  for (const Rows& own : rows_) out.middleRows(own.first, own.count) *= own.root;
  Eigen::Index next = X.rows();
  for (const Block& block : blocks_) {
    const Matrix w =
        block.inner.solve(block.columns.transpose() * X.middleRows(block.first, block.count));
    out.middleRows(block.first, block.count).noalias() -= block.columns * w;
    out.middleRows(next, w.rows()) = w;
    next += w.rows();
  }
  return out;
}

Matrix RandomWeights::inverse(const Matrix& X) const {
  Matrix out = stacked(X).topRows(X.rows());
  for (const Rows& own : rows_) out.middleRows(own.first, own.count) *= own.root;
  return out;
}

}  // namespace jaculus::diagnosis
