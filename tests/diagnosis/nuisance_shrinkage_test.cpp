// Nuisances that are taken off channel by channel, beside the same by vectors as long as all rows.

#include "diagnosis/noise/nuisance_shrinkage.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "diagnosis/normal_matrix.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kChannels = 3, kRowsEach = 20, kAllRows = kChannels * kRowsEach;

std::vector<std::pair<int, int>> channels() {
  std::vector<std::pair<int, int>> spans;
  for (int c = 0; c < kChannels; ++c) spans.emplace_back(c * kRowsEach, kRowsEach);
  return spans;
}

/// Two nuisances of all channels, one of them large, two modes of each channel, one that does
/// nothing and one that is nearly another.
Matrix nuisances() {
  Matrix A = Matrix::Zero(kAllRows, 2 + 2 * kChannels + 2);
  A.leftCols(2) = normal_matrix(kAllRows, 2, 1);
  A.col(0) *= 40.0;
  for (int c = 0; c < kChannels; ++c)
    A.block(c * kRowsEach, 2 + 2 * c, kRowsEach, 2) = 0.3 * normal_matrix(kRowsEach, 2, 2 + c);
  A.rightCols<1>() = A.col(1) + 1e-9 * normal_matrix(kAllRows, 1, 9);
  return A;
}

TEST(NuisanceShrinkage, IsTheRootOfTheInverse) {
  const Matrix A = nuisances();
  Matrix root = Matrix::Identity(kAllRows, kAllRows);
  NuisanceShrinkage(A, channels(), kInfinity).apply(root);
  const Matrix M = Matrix::Identity(kAllRows, kAllRows) + A * A.transpose();
  EXPECT_LT((root - root.transpose()).norm(), 1e-10);
  EXPECT_LT((root * M * root - Matrix::Identity(kAllRows, kAllRows)).norm(), 1e-4);
  EXPECT_LT((root - Eigen::SelfAdjointEigenSolver<Matrix>(M).operatorInverseSqrt()).norm(), 1e-4);
}

TEST(NuisanceShrinkage, AgreesWithVectorsAsLongAsAllRows) {
  Matrix X = normal_matrix(kAllRows, 4, 7), by_vectors = X;
  NuisanceShrinkage(nuisances(), channels(), kInfinity).apply(X);
  shrinkage(nuisances()).apply(by_vectors);
  EXPECT_LT((X - by_vectors).norm(), 1e-10);

  Vector alone = normal_matrix(kAllRows, 4, 7).col(2);
  shrinkage(nuisances()).apply(alone);
  EXPECT_LT((by_vectors.col(2) - alone).norm(), 1e-12);
}

TEST(NuisanceShrinkage, LargeDirectionsAreTakenOff) {
  const NuisanceShrinkage own(nuisances(), channels(), 100.0);
  const Shrinkage& apart = own.apart();
  ASSERT_EQ(apart.shrink.size(), 1);  // 40 sqrt(60) = 310; the others' are below 10
  EXPECT_NEAR(apart.U.col(0).norm(), 1.0, 1e-12);
  Matrix x = normal_matrix(kAllRows, 1, 10);
  own.apply(x);
  EXPECT_LT(std::abs(apart.U.col(0).dot(x.col(0))), 1e-10);

  // With it put back as it would have shrunk, nothing is lost.
  Vector whole = normal_matrix(kAllRows, 1, 10);
  const double along = apart.U.col(0).dot(whole);
  NuisanceShrinkage(nuisances(), channels(), kInfinity).apply(whole);
  EXPECT_LT((x + (1.0 - apart.shrink[0]) * along * apart.U - whole).norm(), 1e-9);
}

TEST(NuisanceShrinkage, NoNuisancesChangeNothing) {
  Matrix X = normal_matrix(kAllRows, 2, 11);
  const Matrix before = X;
  NuisanceShrinkage(Matrix(kAllRows, 0), channels(), kInfinity).apply(X);
  NuisanceShrinkage().apply(X);
  EXPECT_EQ(X, before);
}

}  // namespace
}  // namespace jaculus::diagnosis
