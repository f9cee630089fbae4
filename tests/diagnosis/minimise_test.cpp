// Steps within bounds, and what a fit's minimiser makes of them.

#include "diagnosis/selection/minimise.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "diagnosis/noise/random_weights.h"
#include "diagnosis/selection/box_step.h"
#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/fit.h"
#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

using test::toy_problem;

/// Where a parameter is free the model is flat, and at a bound it falls outwards.
void expect_least(const Matrix& H, const Vector& g, const Vector& lower, const Vector& upper,
                  const Vector& d) {
  const Vector slope = g + H * d;
  const double rounding = 1e-6 * g.lpNorm<Eigen::Infinity>();
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    EXPECT_GE(d[i], lower[i]);
    EXPECT_LE(d[i], upper[i]);
    if (d[i] > lower[i]) {
      EXPECT_LE(slope[i], rounding) << i;
    }
    if (d[i] < upper[i]) {
      EXPECT_GE(slope[i], -rounding) << i;
    }
  }
}

TEST(BoxStep, IsLeastWithinBoundsOfRandomModels) {
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto number = [&] { return normal(generator); };
  const auto width = [&] { return uniform(generator); };
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + trial % 30;
    // Columns of very different sizes, nearly dependent, with the prior's share.
    Matrix J = Matrix::NullaryExpr(n + 3, n, number);
    for (int i = 1; i < n; ++i) J.col(i) = J.col(i - 1) + std::pow(10.0, -(i % 4)) * J.col(i);
    const Matrix H = J.transpose() * J + 1e-3 * Matrix::Identity(n, n);
    const Vector g = 3.0 * Vector::NullaryExpr(n, number);
    Vector lower = -Vector::NullaryExpr(n, width), upper = Vector::NullaryExpr(n, width);
    if (trial % 3 == 0) lower[0] = upper[0] = 0.0;
    if (trial % 5 == 0) upper[n - 1] = kInfinity;
    expect_least(H, g, lower, upper, box_step(H, g, lower, upper));
  }
}

TEST(BoxStep, IsNewtonsWithoutBounds) {
  const Matrix H{{2.0, 1.9}, {1.9, 2.0}};
  const Vector g{{1.0, -1.0}}, far = Vector::Constant(2, kInfinity);
  const Vector expected = -H.llt().solve(g);
  EXPECT_LT((box_step(H, g, -far, far) - expected).norm(), 1e-12);
}

struct Toy {
  std::shared_ptr<Problem> problem = toy_problem(test::toy_truth(0.3, 0.1));
  Comparison comparison = comparison_about(
      *problem, with_random_effects(*problem, estimate_noise(*problem, Vector::Zero(4))));
  Vector scales = first_scales(comparison.whitening.random);

  Residual residual() const { return {*problem, comparison.whitening, {0, 1}, Vector::Zero(4)}; }
};

TEST(Minimise, ReachesTheNormalEquationsOfALinearProblem) {
  const Toy toy;
  Residual residual = toy.residual();
  const RandomEffects& random = toy.comparison.whitening.random;
  const RandomWeights weights(random, toy.scales);
  Vector u = Vector::Zero(2), r0, r;
  Matrix J;
  ASSERT_TRUE(residual.value(u, r0));
  J = *residual.slopes(u);
  const auto moved = minimise(residual, random, toy.scales, Misfits::held, {20}, u);
  ASSERT_TRUE(moved && moved->settled);

  const Matrix W = weights.stacked(J), root = weights.stacked(r0);
  const Matrix H = W.transpose() * W + Matrix::Identity(2, 2);
  const Vector expected = -H.ldlt().solve(W.transpose() * root);
  EXPECT_LT((u - expected).norm(), 1e-3 * expected.norm());
  ASSERT_TRUE(residual.value(u, r));
  const double before = 0.5 * root.squaredNorm(),
               after = 0.5 * (weights.stacked(r).squaredNorm() + u.squaredNorm());
  EXPECT_NEAR(moved->fell, before - after, 1e-6 * before);
}

TEST(Minimise, MovesTheOthersToTheirBestWhereOneIsAtItsBound) {
  Toy toy;
  toy.problem->hypotheses.parameters[0].bounds.upper = 0.2;  // the truth is 0.3
  Residual residual = toy.residual();
  const RandomEffects& random = toy.comparison.whitening.random;
  Vector u = Vector::Zero(2);
  ASSERT_TRUE(minimise(residual, random, toy.scales, Misfits::held, {20}, u));
  EXPECT_DOUBLE_EQ(u[0], 2.0);

  // A point, its slopes, and the same again where the step ends: no more where it is linear.
  EXPECT_LE(residual.predictions(), 6);
  Residual other(*toy.problem, toy.comparison.whitening, {1}, residual.full(u));
  Vector best = Vector::Zero(1);
  ASSERT_TRUE(minimise(other, random, toy.scales, Misfits::held, {20}, best));
  EXPECT_NEAR(u[1], best[0], 1e-3);
}

TEST(Minimise, StaysWhereTheStartCannotBeSimulated) {
  Toy toy;
  toy.problem->forward = [](int, int, const Vector&) { return Prediction{}; };
  Residual residual = toy.residual();
  Vector u = Vector::Zero(2);
  EXPECT_FALSE(
      minimise(residual, toy.comparison.whitening.random, toy.scales, Misfits::held, {20}, u));
}

/// A curved valley (Rosenbrock) behind a place where nothing can be simulated.
TEST(Minimise, FollowsACurvedValleyAroundAHole) {
  Toy toy;
  toy.problem->hypotheses.parameters[0].bounds = {-1.0, 1.0};
  const ForwardModel straight = toy.problem->forward;
  toy.problem->forward = [straight](int d, int t, const Vector& p) {
    if (p[1] > 0.25) return Prediction{};
    Vector bent = p;
    bent[1] = p[1] + 4.0 * p[0] * p[0] - 0.36;  // 0.1 at the truth's 0.3 for p1 = 0.1
    return straight(d, t, bent);
  };
  toy.comparison = comparison_about(
      *toy.problem,
      with_random_effects(*toy.problem, estimate_noise(*toy.problem, Vector::Zero(4))));
  toy.scales = first_scales(toy.comparison.whitening.random);
  Residual residual = toy.residual();
  Vector u{{6.0, -9.0}};
  ASSERT_TRUE(
      minimise(residual, toy.comparison.whitening.random, toy.scales, Misfits::held, {40}, u));
  EXPECT_NEAR(u[0], 3.0, 0.05);
  EXPECT_NEAR(u[1], 1.0, 0.1);
}

/// The first two as tolerances that every fit frees.
std::shared_ptr<Problem> problem_of_tolerances() {
  auto problem = toy_problem(test::toy_truth(0.3, 0.1));
  problem->hypotheses.candidates.clear();
  problem->hypotheses.tolerances = {0, 1};
  return problem;
}

TEST(Minimise, EndsUnsettledBySlopesThatSayNothingAndAFitTellsThemAnew) {
  const auto problem = problem_of_tolerances();
  const Comparison about = comparison_about(*problem, estimate_noise(*problem, Vector::Zero(4)));
  const Fit anew = fit_model(*problem, about.whitening, {0, 1}, {Vector::Zero(4)});
  ASSERT_TRUE(anew.valid);

  const Matrix wrong = -anew.jacobian;
  Residual residual(*problem, about.whitening, {0, 1}, Vector::Zero(4), wrong);
  const RandomEffects& random = about.whitening.random;
  Vector u = Vector::Constant(2, 0.5);
  const auto moved = minimise(residual, random, first_scales(random), Misfits::held, {20}, u);
  ASSERT_TRUE(moved);
  EXPECT_FALSE(moved->settled);

  FitOptions options;
  options.known = wrong;
  const Fit fit = fit_model(*problem, about.whitening, {0, 1}, {Vector::Zero(4)}, options);
  EXPECT_NEAR(fit.log_evidence, anew.log_evidence, problem->settings.scales_settled);
}

TEST(RowSlopes, StandInForDifferencesInAnotherSpace) {
  const auto problem = problem_of_tolerances();
  const Comparison near = comparison_about(*problem, estimate_noise(*problem, Vector::Zero(4)));
  FitOptions keep;
  keep.keep_rows = true;
  const Fit fit = fit_model(*problem, near.whitening, {0, 1}, {Vector::Zero(4)}, keep);
  ASSERT_TRUE(fit.valid);
  ASSERT_EQ(fit.nuisance_rows.columns.size(), 2U);
  EXPECT_LT((near.whitening.slopes(fit.nuisance_rows) - fit.jacobian).norm(),
            1e-6 * fit.jacobian.norm());

  // Three times the noise: a third of the slopes, and a fit from them takes no differences first.
  NoiseModel loud = estimate_noise(*problem, fit.p);
  for (ChannelNoise& channel : loud.datasets[0].channels) channel.noise_floor *= 3.0;
  const Comparison about = comparison_about(*problem, std::move(loud));
  FitOptions known;
  known.known_rows = fit.nuisance_rows;
  known.keep_rows = true;
  Residual residual(*problem, about.whitening, {0, 1}, fit.p,
                    about.whitening.slopes(fit.nuisance_rows));
  Vector u = residual.reduced(fit.p), r;
  Matrix J, renewed;
  ASSERT_TRUE(residual.value(u, r));
  J = *residual.slopes(u);
  EXPECT_EQ(residual.predictions(), 1);
  renewed = *residual.renewed_slopes(u);
  // Up to clocks, which were aligned anew: a thousandth of what a row changes by.
  EXPECT_LT((J - renewed).norm(), 1e-2 * renewed.norm());
  const Fit by_known = fit_model(*problem, about.whitening, {0, 1}, {fit.p}, known);
  const Fit anew = fit_model(*problem, about.whitening, {0, 1}, {fit.p});
  EXPECT_NEAR(by_known.log_evidence, anew.log_evidence, problem->settings.scales_settled);
}

}  // namespace
}  // namespace jaculus::diagnosis
