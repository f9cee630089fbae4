#include "diagnosis/selection/strong_directions.h"

#include <Eigen/Eigenvalues>

namespace jaculus::diagnosis {

StrongDirections strong_directions(const Matrix& slopes, double least, double changed) {
  const Eigen::Index n = slopes.cols();
  if (n == 0) return {};
  Matrix gram = Matrix::Zero(n, n);
  gram.selfadjointView<Eigen::Lower>().rankUpdate(slopes.transpose());
  const Vector squares = gram.diagonal();
  gram.diagonal() *= 1.0 + changed * changed;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(gram);
  const Eigen::Index strong = (eigen.eigenvalues().array() > least * least).count();
  StrongDirections out{eigen.eigenvectors().rightCols(strong), {}};
  const Vector moved = (slopes * out.along).colwise().norm();
  out.sizes = moved.cwiseMax((out.along.cwiseAbs2().transpose() * squares).cwiseSqrt());
  return out;
}

Matrix told_along(const Matrix& slopes, const Matrix& along, const Matrix& told) {
  return slopes + (told - slopes * along) * along.transpose();
}

}  // namespace jaculus::diagnosis
