#include "diagnosis/selection/interval_basis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "diagnosis/noise/quantiles.h"

namespace jaculus::diagnosis {
namespace {

// Of the fixed point. Chosen: it closes in by told_c/n_c a step, to far less than intervals show.
constexpr int kMostSteps = 50;
constexpr double kArrived = 1e-4;  // relative step [-]
// Values that a coordinate leaves at least [-]. Derivation: with one a deviation is Cauchy's, with
// less no quantile is of use.
constexpr double kLeastFreedom = 1.0;

/// H^-1 of X = [r J].
Matrix covariance_by(const RandomEffects& random, const Products& products, const Vector& scales) {
  const Matrix gram = weigh(random, products, scales).gram;
  const Eigen::Index n = gram.cols() - 1;
  const Matrix H = gram.bottomRightCorner(n, n) + Matrix::Identity(n, n);
  return H.llt().solve(Matrix::Identity(n, n));
}

/// tr(H^-1 J_c^T J_c).
double taken(const Matrix& covariance, const Matrix& gram) {
  const Eigen::Index n = covariance.cols();
  return covariance.cwiseProduct(gram.bottomRightCorner(n, n)).sum();
}

}  // namespace

double IntervalBasis::deviation(const Vector& a) const { return std::sqrt(a.dot(covariance * a)); }

double IntervalBasis::quantile(const Vector& a) const {
  const Vector j = covariance * a;
  double uncertain = 0.0;
  for (const Coordinate& own : coordinates) {
    const double part = j.dot(own.information * j);
    uncertain += part * part / own.freedom;
  }
  const double variance = a.dot(j), freedom = variance * variance / uncertain;
  if (!std::isfinite(freedom)) return quantiles::kTwoSided95;
  const boost::math::students_t student(std::max(kLeastFreedom, freedom));
  return boost::math::quantile(student, 0.975);
}

IntervalBasis interval_basis(const Whitening& whitening, const Fit& fit) {
  const RandomEffects& random = whitening.random;
  IntervalBasis basis{fit.scales, fit.covariance, {}};
  if (random.misfits.empty() || fit.free.empty()) return basis;

  Matrix X(fit.residual.size(), 1 + fit.jacobian.cols());
  X << fit.residual, fit.jacobian;
  const Products products = products_of(random, X);
  for (int step = 0; step < kMostSteps; ++step) {
    double moved = 0.0;
    for (std::size_t c = 0; c < random.misfits.size(); ++c) {
      const Misfit& own = random.misfits[c];
      if (own.rows <= 0.0) continue;
      const RandomGroup& group = random.groups[own.group];
      const double energy =
          products.misfits[c](0, 0) + taken(basis.covariance, products.misfits[c]);
      const double next =
          std::clamp(std::sqrt(std::max(0.0, energy / own.rows - 1.0)), group.least, group.largest);
      moved = std::max(moved, std::abs(std::log(next / basis.scales[own.group])));
      basis.scales[own.group] = next;
    }
    basis.covariance = covariance_by(random, products, basis.scales);
    if (moved < kArrived) break;
  }

  const Eigen::Index n = basis.covariance.cols();
  for (std::size_t c = 0; c < random.misfits.size(); ++c) {
    const Misfit& own = random.misfits[c];
    const double s = basis.scales[own.group];
    if (own.rows <= 0.0 || s <= random.groups[own.group].least) continue;
    const double v = own.variance(s);
    const double told = taken(basis.covariance, products.misfits[c]) / v;
    basis.coordinates.push_back({products.misfits[c].bottomRightCorner(n, n) / v,
                                 std::max(kLeastFreedom, own.values - told)});
  }
  return basis;
}

}  // namespace jaculus::diagnosis
