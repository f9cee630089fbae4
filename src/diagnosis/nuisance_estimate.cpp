#include "diagnosis/nuisance_estimate.h"

#include <Eigen/Cholesky>

namespace jaculus {

Vector nuisance_deviation(const RunNuisances& n, const Vector& r, const Vector& weight) {
  const Matrix A = weight.asDiagonal() * n.columns * n.scale.asDiagonal();
  const Matrix H = A.transpose() * A + Matrix::Identity(A.cols(), A.cols());
  return n.scale.cwiseProduct(H.ldlt().solve(A.transpose() * weight.cwiseProduct(r)));
}

}  // namespace jaculus
