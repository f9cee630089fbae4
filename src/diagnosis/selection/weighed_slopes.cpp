#include "diagnosis/selection/weighed_slopes.h"

namespace jaculus::diagnosis {

WeighedSlopes::WeighedSlopes(const RandomWeights& weights, std::vector<Part> parts)
    : weights_(weights), parts_(std::move(parts)), grams_(parts_.size()) {}

void WeighedSlopes::follow(Residual& residual, bool told) {
  const Eigen::Index before = residual.first_followed();
  const std::vector<Residual::Secant>& secants = residual.secants();
  if (W_.size() == 0 || renewed_ != residual.times_renewed()) {
    W_ = weights_.stacked(residual.told());
    added_.clear();
    for (std::size_t k = 0; k < parts_.size(); ++k) grams_[k] = gram_of(parts_[k]);
  } else {
    for (; followed_ < secants.size(); ++followed_) add(secants[followed_]);
    if (before > 0 && told) renew(residual.told_before());
  }
  renewed_ = residual.times_renewed();
  followed_ = secants.size();
}

Matrix WeighedSlopes::gram(const Vector& shares) const {
  Matrix sum = Matrix::Zero(W_.cols(), W_.cols());
  for (std::size_t k = 0; k < parts_.size(); ++k)
    sum += shares[static_cast<Eigen::Index>(k)] * grams_[k];
  return sum;
}

Vector WeighedSlopes::along(const Vector& shares, const Vector& x) const {
  Vector sum = Vector::Zero(W_.cols());
  for (std::size_t k = 0; k < parts_.size(); ++k)
    sum += shares[static_cast<Eigen::Index>(k)] * along_part(parts_[k], x);
  return sum;
}

Matrix WeighedSlopes::gram_of(const Part& part) const {
  Matrix gram = Matrix::Zero(W_.cols(), W_.cols());
  for (const auto& [first, count] : part)
    gram.selfadjointView<Eigen::Lower>().rankUpdate(W_.middleRows(first, count).transpose());
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  return gram;
}

template <class Columns>
Matrix WeighedSlopes::along_part(const Part& part, const Columns& X) const {
  Matrix sum = Matrix::Zero(W_.cols(), X.cols());
  for (const auto& [first, count] : part) {
    const auto own = X.middleRows(first, count);
    sum.noalias() += W_.middleRows(first, count).transpose() * own;
    for (const Added& added : added_)
      sum.noalias() += added.along * (added.w.segment(first, count).transpose() * own);
  }
  return sum;
}

void WeighedSlopes::renew(ConstMatrixRef J) {
  const Eigen::Index before = J.cols();
  const Matrix first = weights_.stacked(J);
  W_.leftCols(before) = first;
  for (Added& added : added_) added.along.head(before).setZero();
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    grams_[k].leftCols(before) = along_part(parts_[k], first);
    grams_[k].topRows(before) = grams_[k].leftCols(before).transpose();
  }
}

void WeighedSlopes::add(const Residual::Secant& secant) {
  const Vector w = weights_.stacked(secant.missed);
  Vector s = Vector::Zero(W_.cols());
  s.head(secant.along.size()) = secant.along;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const Vector v = along_part(parts_[k], w);
    double square = 0.0;
    for (const auto& [first, count] : parts_[k]) square += w.segment(first, count).squaredNorm();
    grams_[k] += v * s.transpose() + s * v.transpose() + square * (s * s.transpose());
  }
  added_.push_back({w, std::move(s)});
}

}  // namespace jaculus::diagnosis
