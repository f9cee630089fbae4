#include "evaluation/ridge.h"

#include <algorithm>
#include <cmath>

namespace jaculus::evaluation {
namespace {

constexpr int kFolds = 5;
constexpr int kSweeps = 500;
constexpr double kStill = 1e-9;  ///< largest move of a sweep that ends it
/// Weights that are tried: 1 is the priors' own.
constexpr double kWeights[] = {1e-2, 1e-1, 1.0, 10.0, 1e2, 1e3, 1e4, 1e5};

/// The minimum for normal equations A = G^T G, b = G^T r.
Vector minimum(const Matrix& A, const Vector& b, double lambda, const std::vector<Bounds>& ranges) {
  Vector u = Vector::Zero(b.size());
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double moved = 0.0;
    for (int j = 0; j < count_of(ranges); ++j) {
      const double pull = b[j] - A.row(j).dot(u) + A(j, j) * u[j];
      const double next = std::clamp(pull / (A(j, j) + lambda), ranges[j].lower, ranges[j].upper);
      moved = std::max(moved, std::abs(next - u[j]));
      u[j] = next;
    }
    if (moved < kStill) break;
  }
  return u;
}

}  // namespace

RidgeFit ridge(const Matrix& G, const Vector& r, const std::vector<Bounds>& ranges) {
  const Matrix A = G.transpose() * G;
  const Vector b = G.transpose() * r;
  RidgeFit best;
  double least = kInfinity;

  for (const double lambda : kWeights) {
    double error = 0.0;
    for (int fold = 0; fold < kFolds; ++fold) {
      const Eigen::Index first = r.size() * fold / kFolds;
      const Eigen::Index count = r.size() * (fold + 1) / kFolds - first;
      const auto held = G.middleRows(first, count);
      const auto rest = r.segment(first, count);
      const Vector u =
          minimum(A - held.transpose() * held, b - held.transpose() * rest, lambda, ranges);
      error += (rest - held * u).squaredNorm();
    }
    if (error >= least) continue;
    least = error;
    best.lambda = lambda;
  }

  best.u = minimum(A, b, best.lambda, ranges);
  return best;
}

}  // namespace jaculus::evaluation
