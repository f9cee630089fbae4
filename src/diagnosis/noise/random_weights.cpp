#include "diagnosis/noise/random_weights.h"

namespace jaculus::diagnosis {

RandomWeights::RandomWeights(const RandomEffects& effects, const Vector& scales)
    : effects_(&effects) {
  Matrix tolerances = effects.tolerance_gram;
  tolerances.diagonal().array() += 1.0;

  for (const RandomBlock& own : effects.blocks) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = 0; k < own.columns.cols(); ++k)
      if (scales[own.group[k]] > 0.0) kept.push_back(k);
    Vector deviations(count_of(kept));
    for (int k = 0; k < count_of(kept); ++k) deviations[k] = scales[own.group[kept[k]]];
    const auto S = deviations.asDiagonal();

    Matrix inner = S * own.gram(kept, kept) * S;
    inner.diagonal().array() += 1.0;
    Block block{own.first, own.count, own.columns(Eigen::all, kept) * S, inner.llt(), {}};
    const Matrix along = S * own.with_tolerances(kept, Eigen::all);
    block.with_tolerances = block.inner.solve(along);
    tolerances.noalias() -= along.transpose() * block.with_tolerances;
    forces_ += deviations.size();
    blocks_.push_back(std::move(block));
  }

  tolerance_inner_.compute(tolerances);
}

Matrix RandomWeights::stacked(const Matrix& X) const {
  // Forces alone, then tolerances, then what these leave to the forces.
  Matrix c = effects_->tolerances.transpose() * X;
  std::vector<Matrix> forces;
  for (const Block& block : blocks_) {
    const Matrix along = block.columns.transpose() * X.middleRows(block.first, block.count);
    c.noalias() -= block.with_tolerances.transpose() * along;
    forces.push_back(block.inner.solve(along));
  }
  c = tolerance_inner_.solve(c);

  Matrix out(X.rows() + more_rows(), X.cols());
  out.topRows(X.rows()) = X;
  out.topRows(X.rows()).noalias() -= effects_->tolerances * c;
  Eigen::Index next = X.rows();
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Block& block = blocks_[b];
    forces[b].noalias() -= block.with_tolerances * c;
    out.middleRows(block.first, block.count).noalias() -= block.columns * forces[b];
    out.middleRows(next, forces[b].rows()) = forces[b];
    next += forces[b].rows();
  }
  out.bottomRows(c.rows()) = c;
  return out;
}

}  // namespace jaculus::diagnosis
