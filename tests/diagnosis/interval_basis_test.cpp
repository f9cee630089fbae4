// Intervals where a misfit was estimated from few values: Student's, as textbooks have it, and that
// they cover as often as they say.

#include "diagnosis/selection/interval_basis.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

namespace jaculus::diagnosis {
namespace {

constexpr int kRowsOfMisfit = 600;
constexpr double kValuesOfMisfit = 6.0;

/// One coordinate whose rows the parameters move by J; those of the prior alone where it has none.
struct LinearFit {
  Whitening whitening;
  Fit fit;
};

LinearFit linear_fit(const Matrix& J, const Vector& residual, double least) {
  LinearFit out;
  RandomGroup group{"misfit of x"};
  group.least = least;
  out.whitening.random.groups = {group};
  out.whitening.random.misfits = {
      {0, kValuesOfMisfit, double(kRowsOfMisfit), {{0, kRowsOfMisfit}}}};
  for (int i = 0; i < J.cols(); ++i) out.fit.free.push_back(i);
  out.fit.residual = residual;
  out.fit.jacobian = J;
  const RandomEffects& random = out.whitening.random;
  out.fit.scales = misfits_of(random, residual, Vector::Constant(1, least));
  const double v = random.misfits[0].variance(out.fit.scales[0]);
  out.fit.covariance = (J.transpose() * J / v + Matrix::Identity(J.cols(), J.cols())).inverse();
  return out;
}

/// `columns` values of the misfit tell a parameter each, so well that priors are nothing.
Matrix told_columns(int columns) {
  Matrix J = Matrix::Zero(kRowsOfMisfit, columns);
  for (int k = 0; k < columns; ++k) J(k, k) = 1e4;
  return J;
}

/// What is left of n values of a misfit once the first `told` of them are fitted, and rows of noise
/// alone of mean square one.
Vector left_of(const Vector& misfit, int told) {
  Vector r = Vector::Ones(kRowsOfMisfit);
  r.head(misfit.size()) = misfit;
  r.head(told).setZero();
  return r;
}

TEST(IntervalBasis, IsStudentsWhereAMisfitIsEstimatedBesideTheParameter) {
  const Vector misfit{{0.0, 40.0, -10.0, 25.0, -30.0, 5.0}};
  const LinearFit own = linear_fit(told_columns(1), left_of(misfit, 1), 0.0);
  const IntervalBasis basis = interval_basis(own.whitening, own.fit);

  // Five values are left of six: v = (E - N + n)/(n - 1), and t of five degrees of freedom.
  const double v = misfit.squaredNorm() / (kValuesOfMisfit - 1.0);
  const Vector a = Vector::Ones(1);
  EXPECT_NEAR(basis.deviation(a), std::sqrt(v) / 1e4, 1e-3 * std::sqrt(v) / 1e4);
  EXPECT_NEAR(basis.quantile(a), 2.5706, 1e-3);
  // By the most likely size alone it would be told better than it is.
  EXPECT_LT(std::sqrt(own.fit.covariance(0, 0)), 0.92 * basis.deviation(a));
}

TEST(IntervalBasis, IsTheFitsOwnWhereNoMisfitWasEstimated) {
  const Vector r = 0.5 * Vector::Ones(kRowsOfMisfit);
  const LinearFit own = linear_fit(told_columns(2), r, 0.3);
  const IntervalBasis basis = interval_basis(own.whitening, own.fit);
  const Vector a = Vector::Unit(2, 1);
  EXPECT_EQ(basis.scales, own.fit.scales);
  EXPECT_NEAR(basis.deviation(a), std::sqrt(own.fit.covariance(1, 1)), 1e-12);
  EXPECT_NEAR(basis.quantile(a), 1.959964, 1e-6);
}

TEST(IntervalBasis, LeavesAParameterThatNoMisfitTellsToItsPrior) {
  const Vector misfit{{0.0, 40.0, -10.0, 25.0, -30.0, 5.0}};
  Matrix J = told_columns(2);
  J.col(1).setZero();
  const LinearFit own = linear_fit(J, left_of(misfit, 1), 0.0);
  const IntervalBasis basis = interval_basis(own.whitening, own.fit);
  EXPECT_NEAR(basis.deviation(Vector::Unit(2, 1)), 1.0, 1e-9);
  EXPECT_NEAR(basis.quantile(Vector::Unit(2, 1)), 1.959964, 1e-6);
}

TEST(IntervalBasis, CoversAsOftenAsItSays) {
  constexpr int kDraws = 2000, kTold = 3;
  std::mt19937 generator(5);
  std::normal_distribution<double> normal(0.0, 30.0);
  int covered = 0, covered_by_likely = 0;
  const Vector a = Vector::Unit(kTold, 0);
  for (int draw = 0; draw < kDraws; ++draw) {
    const Vector misfit =
        Vector::NullaryExpr(int(kValuesOfMisfit), [&](Eigen::Index) { return normal(generator); });
    const LinearFit own = linear_fit(told_columns(kTold), left_of(misfit, kTold), 0.0);
    const IntervalBasis basis = interval_basis(own.whitening, own.fit);
    const double error = std::abs(misfit[0]) / 1e4;  // the truth is zero
    covered += error < basis.quantile(a) * basis.deviation(a) ? 1 : 0;
    covered_by_likely += error < 1.96 * std::sqrt(own.fit.covariance(0, 0)) ? 1 : 0;
  }

  // Three deviations of a share of 0.95 are 0.015.
  EXPECT_NEAR(covered / double(kDraws), 0.95, 0.015);
  EXPECT_LT(covered_by_likely / double(kDraws), 0.85);
}

}  // namespace
}  // namespace jaculus::diagnosis
