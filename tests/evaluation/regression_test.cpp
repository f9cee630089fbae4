// Regressions and ranks against what can be worked out by hand.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "evaluation/rank_statistics.h"
#include "evaluation/ridge.h"
#include "evaluation/sparse_regression.h"

namespace jaculus::evaluation {
namespace {

Vector noise(int rows, double deviation, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, deviation);
  Vector x(rows);
  for (double& one : x) one = normal(random);
  return x;
}

/// 1, sign, speed, speed^3 and a column of zeros, of a speed that swings.
Matrix library(int rows) {
  Matrix X(rows, 5);
  for (int i = 0; i < rows; ++i) {
    const double speed = 3.0 * std::sin(0.11 * i) + std::sin(0.37 * i);
    X.row(i) << 1.0, speed > 0.0 ? 1.0 : -1.0, speed, speed * speed * speed, 0.0;
  }
  return X;
}

TEST(SparseRegression, KeepsTheTermsThatAreThereWithTheirCoefficients) {
  const Matrix X = library(400);
  const Vector y = 0.4 * X.col(1) - 0.3 * X.col(2) + noise(400, 0.02, 1);
  const SparseFit fit = sparse_regression(X, y);
  EXPECT_NEAR(fit.coefficients[1], 0.4, 0.02);
  EXPECT_NEAR(fit.coefficients[2], -0.3, 0.02);
  EXPECT_EQ(fit.coefficients[4], 0.0) << "a column of zeros";
  const Vector others = X.col(0) * fit.coefficients[0] + X.col(3) * fit.coefficients[3];
  EXPECT_LT(others.norm(), 0.05 * y.norm());
}

TEST(SparseRegression, NothingIsKeptOfNoiseOrOfNoData) {
  const SparseFit none = sparse_regression(library(400), noise(400, 1.0, 2));
  EXPECT_LT((library(400) * none.coefficients).norm(), 4.0);  // of 20
  const SparseFit zero = sparse_regression(library(50), Vector::Zero(50));
  EXPECT_TRUE(std::isinf(zero.threshold));
  EXPECT_TRUE(zero.coefficients.isZero());
}

TEST(Ridge, SolvesTheNormalEquationsAtItsWeight) {
  const Matrix G = library(300).leftCols(4);
  const Vector r = G * Vector::LinSpaced(4, 0.1, 0.4) + noise(300, 0.5, 3);
  const RidgeFit fit = ridge(G, r, std::vector<Bounds>(4, {-kInfinity, kInfinity}));
  Matrix A = G.transpose() * G;
  A.diagonal().array() += fit.lambda;
  EXPECT_LT((A * fit.u - G.transpose() * r).norm(), 1e-4 * (G.transpose() * r).norm());
}

TEST(Ridge, ShrinksNoiseAndKeepsBounds) {
  const Matrix G = library(300).leftCols(4);
  const std::vector<Bounds> free(4, {-kInfinity, kInfinity});
  EXPECT_GT(ridge(G, noise(300, 1.0, 4), free).lambda, 10.0);
  EXPECT_LE(ridge(G, G.col(2), free).lambda, 0.1);
  const RidgeFit held = ridge(G, -G.col(1), {free[0], {0.0, 5.0}, free[2], free[3]});
  EXPECT_EQ(held.u[1], 0.0);
}

TEST(RankStatistics, UniformRanksAndAHeap) {
  std::vector<int> even;
  for (int rank = 0; rank < 100; ++rank) even.push_back(rank);
  const RankStatistics uniform = rank_statistics(even, 99, 10);
  EXPECT_EQ(uniform.chi2, 0.0);
  EXPECT_NEAR(uniform.probability, 1.0, 1e-12);
  EXPECT_NEAR(uniform.ecdf, 0.0, 1e-12);
  EXPECT_NEAR(uniform.band, 0.1358, 1e-4);

  const RankStatistics heap = rank_statistics(std::vector<int>(100, 50), 99, 10);
  EXPECT_NEAR(heap.chi2, 900.0, 1e-9);  // (100 - 10)^2/10 + 9 * 10
  EXPECT_LT(heap.probability, 1e-9);
  EXPECT_NEAR(heap.ecdf, 0.50, 1e-12);
  EXPECT_EQ(heap.histogram[5], 100);
  // Chi-square of 16.919 with 9 degrees of freedom has an upper tail of 0.05.
  std::vector<int> bent;
  for (int bin = 0; bin < 10; ++bin)
    bent.insert(bent.end(), bin == 0 ? 22 : bin == 1 ? 10 : bin < 6 ? 9 : 8, 10 * bin);
  const RankStatistics some = rank_statistics(bent, 99, 10);
  ASSERT_EQ(some.count, 100);
  EXPECT_NEAR(some.chi2, 16.4, 1e-9);
  EXPECT_NEAR(some.probability, 0.05, 0.02);
}

TEST(RankStatistics, ARightPosteriorHasUniformRanksAndANarrowOneHasNot) {
  // Truth from N(0, 1), one datum of unit noise: the posterior is N(y/2, 1/2).
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto ranks = [&](double deviation) {
    std::vector<int> list;
    const std::vector<Bounds> free = {{-kInfinity, kInfinity}};
    for (int k = 0; k < 400; ++k) {
      const double truth = normal(random), y = truth + normal(random);
      int rank = 0;
      for (int d = 0; d < 99; ++d) {
        const Vector draw = bounded_normal(Vector::Constant(1, 0.5 * y),
                                           Matrix::Constant(1, 1, deviation), free, random);
        rank += draw[0] < truth ? 1 : 0;
      }
      list.push_back(rank);
    }
    return rank_statistics(list, 99, 10);
  };
  const RankStatistics right = ranks(std::sqrt(0.5)), narrow = ranks(0.35);
  EXPECT_GT(right.probability, 0.01);
  EXPECT_LT(right.ecdf, right.band);
  EXPECT_LT(narrow.probability, 1e-6);
  EXPECT_GT(narrow.histogram.front() + narrow.histogram.back(), 160);
}

TEST(RankStatistics, DrawsStayWithinTheirRange) {
  std::mt19937_64 random(6);
  for (int k = 0; k < 200; ++k) {
    const Vector draw = bounded_normal(Vector::Constant(1, -1.0), Matrix::Identity(1, 1),
                                       {{0.0, kInfinity}}, random);
    ASSERT_EQ(draw.size(), 1);
    EXPECT_GE(draw[0], 0.0);
  }
  EXPECT_EQ(bounded_normal(Vector::Constant(1, -99.0), Matrix::Identity(1, 1), {{0.0, 1.0}}, random)
                .size(),
            0);
}

}  // namespace
}  // namespace jaculus::evaluation
