#include "evaluation/sparse_regression.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <iterator>
#include <vector>

namespace jaculus::evaluation {
namespace {

constexpr int kParts = 5;
constexpr double kRidge = 1e-3;  ///< keeps columns that look alike from cancelling each other
constexpr double kThresholds[] = {0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7};

double root_mean_square(const Vector& x) {
  return x.size() == 0 ? 0.0 : x.norm() / std::sqrt(static_cast<double>(x.size()));
}

/// Coefficients of scaled columns at one threshold.
Vector thresholded(const Matrix& X, const Vector& y, double threshold) {
  std::vector<int> kept;
  const Vector sizes = X.colwise().norm();
  for (int j = 0; j < count_of(sizes); ++j)
    if (sizes[j] > 0.0) kept.push_back(j);

  Vector all = Vector::Zero(X.cols());
  while (!kept.empty()) {
    const Matrix own = X(Eigen::all, kept);
    Matrix normal = own.transpose() * own;
    normal.diagonal().array() += kRidge * static_cast<double>(y.size());
    const Vector c = normal.ldlt().solve(own.transpose() * y);
    std::vector<int> next;
    for (int i = 0; i < count_of(kept); ++i)
      if (std::abs(c[i]) >= threshold) next.push_back(kept[i]);
    if (next.size() == kept.size()) {
      all(kept) = c;
      break;
    }
    kept = next;
  }
  return all;
}

Matrix without_rows(const Matrix& X, Eigen::Index first, Eigen::Index count) {
  Matrix rest(X.rows() - count, X.cols());
  rest << X.topRows(first), X.bottomRows(X.rows() - first - count);
  return rest;
}

/// Mean square error of each held-out part.
Vector held_out_errors(const Matrix& X, const Vector& y, double threshold) {
  Vector errors = Vector::Zero(kParts);
  for (int part = 0; part < kParts; ++part) {
    const Eigen::Index first = y.size() * part / kParts;
    const Eigen::Index count = y.size() * (part + 1) / kParts - first;
    if (count == 0) continue;
    const Vector c =
        thresholded(without_rows(X, first, count), without_rows(y, first, count), threshold);
    errors[part] = (y.segment(first, count) - X.middleRows(first, count) * c).squaredNorm() /
                   static_cast<double>(count);
  }
  return errors;
}

double standard_error(const Vector& errors) {
  return std::sqrt((errors.array() - errors.mean()).square().sum() / (kParts * (kParts - 1.0)));
}

/// The largest threshold whose error is within one standard error of the least; no term at all is
/// the last of them.
double best_threshold(const Matrix& X, const Vector& y) {
  std::vector<double> thresholds(std::begin(kThresholds), std::end(kThresholds));
  thresholds.push_back(kInfinity);
  std::vector<double> means;
  double least = kInfinity, allowed = kInfinity;
  for (const double threshold : thresholds) {
    const Vector errors = held_out_errors(X, y, threshold);
    means.push_back(errors.mean());
    if (means.back() >= least) continue;
    least = means.back();
    allowed = least + standard_error(errors);
  }

  int best = count_of(means) - 1;
  while (best > 0 && means[best] > allowed) --best;
  return thresholds[best];
}

}  // namespace

SparseFit sparse_regression(const Matrix& library, const Vector& data) {
  SparseFit fit{Vector::Zero(library.cols()), kInfinity};
  const double size = root_mean_square(data);
  if (!(size > 0.0)) return fit;

  Vector scale(library.cols());
  Matrix X = library;
  for (Eigen::Index j = 0; j < X.cols(); ++j) {
    const double own = root_mean_square(X.col(j));
    scale[j] = own > 0.0 ? own : 1.0;
    X.col(j) /= scale[j];
  }
  const Vector y = data / size;

  fit.threshold = best_threshold(X, y);
  if (std::isfinite(fit.threshold))
    fit.coefficients = (thresholded(X, y, fit.threshold) * size).cwiseQuotient(scale);
  return fit;
}

}  // namespace jaculus::evaluation
