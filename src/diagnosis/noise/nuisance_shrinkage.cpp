#include "diagnosis/noise/nuisance_shrinkage.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace jaculus::diagnosis {

NuisanceShrinkage::NuisanceShrinkage(const Matrix& A, const std::vector<std::pair<int, int>>& spans,
                                     double apart) {
  if (A.cols() == 0 || A.rows() == 0) return;
  for (const auto& [first, count] : spans) {
    Part part{first, count, {}, {}};
    for (Eigen::Index k = 0; k < A.cols(); ++k)
      if ((A.col(k).segment(first, count).array() != 0.0).any()) part.columns.push_back(k);
    part.A = A.middleRows(first, count)(Eigen::all, part.columns);
    if (!part.columns.empty()) parts_.push_back(std::move(part));
  }

  const Eigen::SelfAdjointEigenSolver<Matrix> solver(gram(A.cols()));
  const Matrix& V = solver.eigenvectors();
  const Vector& energy = solver.eigenvalues();
  Vector weight = Vector::Zero(A.cols());  // g/s^2
  std::vector<Eigen::Index> off;
  for (Eigen::Index k = A.cols() - 1; k >= 0 && energy[k] > kLeastEnergy; --k) {
    const bool whole = energy[k] >= apart * apart;
    if (whole) off.push_back(k);
    weight[k] = (whole ? 1.0 : 1.0 - 1.0 / std::sqrt(1.0 + energy[k])) / energy[k];
  }
  C_ = V * weight.asDiagonal() * V.transpose();

  const Vector s = energy(off).cwiseSqrt();
  apart_.U = Matrix::Zero(A.rows(), s.size());
  const Matrix by_s = V(Eigen::all, off) * s.cwiseInverse().asDiagonal();
  for (const Part& part : parts_)
    apart_.U.middleRows(part.first, part.count) = part.A * by_s(part.columns, Eigen::all);
  apart_.shrink = 1.0 - (1.0 + energy(off).array()).sqrt().inverse();
}

/// A^T A.
Matrix NuisanceShrinkage::gram(Eigen::Index columns) const {
  Matrix sum = Matrix::Zero(columns, columns);
  for (const Part& part : parts_) sum(part.columns, part.columns) += part.A.transpose() * part.A;
  return sum;
}

/// A^T X.
Matrix NuisanceShrinkage::times(ConstMatrixRef X) const {
  Matrix sum = Matrix::Zero(C_.cols(), X.cols());
  for (const Part& part : parts_)
    sum(part.columns, Eigen::all) += part.A.transpose() * X.middleRows(part.first, part.count);
  return sum;
}

void NuisanceShrinkage::apply(MatrixRef X) const {
  if (parts_.empty()) return;
  const Matrix along = C_ * times(X);
  for (const Part& part : parts_)
    X.middleRows(part.first, part.count).noalias() -= part.A * along(part.columns, Eigen::all);
}

}  // namespace jaculus::diagnosis
