// Nuisances that are taken off channel by channel, beside the same by vectors as long as all rows.

#include "diagnosis/noise/nuisance_shrinkage.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

namespace jaculus::diagnosis {
namespace {

constexpr int kChannels = 3, kRowsEach = 20, kAllRows = kChannels * kRowsEach;

Matrix scattered(Eigen::Index rows, Eigen::Index cols, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(rows, cols,
                             [&](Eigen::Index, Eigen::Index) { return normal(generator); });
}

std::vector<std::pair<int, int>> channels() {
  std::vector<std::pair<int, int>> spans;
  for (int c = 0; c < kChannels; ++c) spans.emplace_back(c * kRowsEach, kRowsEach);
  return spans;
}

/// Two nuisances of all channels, one of them large, two modes of each channel, one that does
/// nothing and one that is nearly another.
Matrix nuisances() {
  Matrix A = Matrix::Zero(kAllRows, 2 + 2 * kChannels + 2);
  A.leftCols(2) = scattered(kAllRows, 2, 1);
  A.col(0) *= 40.0;
  for (int c = 0; c < kChannels; ++c)
    A.block(c * kRowsEach, 2 + 2 * c, kRowsEach, 2) = 0.3 * scattered(kRowsEach, 2, 2 + c);
  A.rightCols<1>() = A.col(1) + 1e-9 * scattered(kAllRows, 1, 9);
  return A;
}

TEST(NuisanceShrinkage, IsTheRootOfTheInverse) {
  const Matrix A = nuisances();
  Matrix root = Matrix::Identity(kAllRows, kAllRows);
  NuisanceShrinkage(A, channels(), kInfinity).apply_to_columns(root);
  const Matrix M = Matrix::Identity(kAllRows, kAllRows) + A * A.transpose();
  EXPECT_LT((root - root.transpose()).norm(), 1e-10);
  EXPECT_LT((root * M * root - Matrix::Identity(kAllRows, kAllRows)).norm(), 1e-4);
  EXPECT_LT((root - Eigen::SelfAdjointEigenSolver<Matrix>(M).operatorInverseSqrt()).norm(), 1e-4);
}

TEST(NuisanceShrinkage, AgreesWithVectorsAsLongAsAllRows) {
  Matrix X = scattered(kAllRows, 4, 7), by_vectors = X;
  NuisanceShrinkage(nuisances(), channels(), kInfinity).apply_to_columns(X);
  shrinkage(nuisances()).apply_to_columns(by_vectors);
  EXPECT_LT((X - by_vectors).norm(), 1e-10);

  Vector one = scattered(kAllRows, 1, 8), alone = one;
  shrinkage(nuisances()).apply(one);
  shrinkage(nuisances()).apply_to_columns(alone);
  EXPECT_LT((one - alone).norm(), 1e-12);
}

TEST(NuisanceShrinkage, LargeDirectionsAreTakenOff) {
  const NuisanceShrinkage own(nuisances(), channels(), 100.0);
  const Shrinkage& apart = own.apart();
  ASSERT_EQ(apart.shrink.size(), 1);  // 40 sqrt(60) = 310; the others' are below 10
  EXPECT_NEAR(apart.U.col(0).norm(), 1.0, 1e-12);
  Matrix x = scattered(kAllRows, 1, 10);
  own.apply_to_columns(x);
  EXPECT_LT(std::abs(apart.U.col(0).dot(x.col(0))), 1e-10);

  // With it put back as it would have shrunk, nothing is lost.
  Vector whole = scattered(kAllRows, 1, 10);
  const double along = apart.U.col(0).dot(whole);
  NuisanceShrinkage(nuisances(), channels(), kInfinity).apply_to_columns(whole);
  EXPECT_LT((x + (1.0 - apart.shrink[0]) * along * apart.U - whole).norm(), 1e-9);
}

TEST(NuisanceShrinkage, NoNuisancesChangeNothing) {
  Matrix X = scattered(kAllRows, 2, 11);
  const Matrix before = X;
  NuisanceShrinkage(Matrix(kAllRows, 0), channels(), kInfinity).apply_to_columns(X);
  NuisanceShrinkage().apply_to_columns(X);
  EXPECT_EQ(X, before);
}

}  // namespace
}  // namespace jaculus::diagnosis
