// Random effects against dense Gaussian algebra, and deviations that were planted.

#include "diagnosis/noise/random_effects.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <numbers>

#include "diagnosis/noise/columns.h"
#include "diagnosis/noise/random_weights.h"
#include "diagnosis/normal_matrix.h"
#include "diagnosis/selection/fit.h"

namespace jaculus::diagnosis {
namespace {

/// Two blocks of rows, two groups of columns that change places between them.
RandomEffects small_effects(int rows_each, int columns) {
  RandomEffects effects;
  effects.groups = {{"a", 0}, {"b", 1}};
  for (int b = 0; b < 2; ++b) {
    RandomBlock block;
    block.first = b * rows_each;
    block.count = rows_each;
    block.columns = normal_matrix(rows_each, columns, 11 + b);
    for (int k = 0; k < columns; ++k) block.group.push_back((k + b) % 2);
    block.gram = block.columns.transpose() * block.columns;
    effects.blocks.push_back(block);
  }
  return effects;
}

/// I + G S^2 G^T.
Matrix covariance(const RandomEffects& effects, const Vector& scales) {
  const Eigen::Index n = effects.blocks.back().first + effects.blocks.back().count;
  Matrix V = Matrix::Identity(n, n);
  for (const RandomBlock& block : effects.blocks)
    for (int k = 0; k < count_of(block.group); ++k)
      V.block(block.first, block.first, block.count, block.count) +=
          std::pow(scales[block.group[k]], 2) * block.columns.col(k) *
          block.columns.col(k).transpose();
  return V;
}

TEST(RandomEffects, EvidenceIsTheDenseGaussians) {
  const RandomEffects effects = small_effects(15, 5);
  const Vector scales = Vector{{0.7, 2.5}};
  const Matrix X = normal_matrix(30, 4, 3);
  const Matrix V = covariance(effects, scales);
  const Products products = products_of(effects, X);

  const Weighed weighed = weigh(effects, products, scales);
  const Matrix expected = X.transpose() * V.ldlt().solve(X);
  EXPECT_LT((weighed.gram - expected).norm(), 1e-10 * expected.norm());
  EXPECT_NEAR(weighed.log_det, std::log(V.determinant()), 1e-10);

  // y = Y u + ... with u ~ N(0, I): one more random effect.
  const Matrix all = V + X.rightCols(3) * X.rightCols(3).transpose();
  const double log_density =
      -0.5 * (X.col(0).dot(all.ldlt().solve(X.col(0))) + std::log(all.determinant()));
  EXPECT_NEAR(linear_evidence(effects, products, scales).log_evidence, log_density, 1e-9);
}

/// Blocks of more columns than are inverted at once, beside a model of several columns: by scales
/// that stay, what the fixed point says is what the evidence says, and how many forces the data
/// tell is the trace of a dense posterior.
TEST(RandomEffects, AStepOfTheFixedPointAgreesWithTheDenseGaussian) {
  const RandomEffects effects = small_effects(40, 21);
  const Vector scales = Vector{{0.7, 0.2}};
  const Matrix X = normal_matrix(80, 6, 3);
  const Products products = products_of(effects, X);
  const LinearEvidence evidence = linear_evidence(effects, products, scales);
  const ScaleEstimate estimate = estimated_scales(effects, products, scales, 0, 2.3);
  EXPECT_NEAR(estimate.log_evidence, evidence.log_evidence, 1e-9);
  EXPECT_LT((estimate.mean - evidence.mean).norm(), 1e-10);

  const Matrix V = covariance(effects, scales) + X.rightCols(5) * X.rightCols(5).transpose();
  Vector told = Vector::Zero(2);
  for (const RandomBlock& block : effects.blocks) {
    const Matrix here = V.inverse().block(block.first, block.first, block.count, block.count);
    for (int k = 0; k < count_of(block.group); ++k) {
      const double s = scales[block.group[k]];
      told[block.group[k]] += s * s * block.columns.col(k).dot(here * block.columns.col(k));
    }
  }
  EXPECT_LT((told_by(effects, products, scales) - told).norm(), 1e-9);
}

TEST(RandomEffects, WhatHasNoForceIsPlainLeastSquares) {
  RandomEffects effects = small_effects(15, 5);
  effects.blocks[1].columns.resize(15, 0);
  effects.blocks[1].group.clear();
  effects.blocks[1].gram.resize(0, 0);
  const Matrix X = normal_matrix(30, 60, 3);  // wide: where a product of no rows once failed
  const Products products = products_of(effects, X);
  const Vector scales = Vector{{0.7, 2.5}};
  const ScaleEstimate some = estimated_scales(effects, products, scales, 0, 2.3);
  EXPECT_NEAR(some.log_evidence, linear_evidence(effects, products, scales).log_evidence, 1e-9);

  const RandomEffects none;
  const Products plain = products_of(none, X);
  const ScaleEstimate estimate = estimated_scales(none, plain, {}, 10, 2.3);
  const LinearEvidence evidence = linear_evidence(none, plain, {});
  EXPECT_EQ(estimate.log_evidence, evidence.log_evidence);
  EXPECT_EQ(estimate.mean, evidence.mean);
}

TEST(RandomEffects, WeightsAreTheInverseOfTheCovariance) {
  const RandomEffects effects = small_effects(12, 4);
  for (const Vector& scales : {Vector{{1.5, 0.2}}, Vector{{0.0, 0.7}}, Vector{{0.0, 0.0}}}) {
    const Matrix X = normal_matrix(24, 5, 100);
    const Matrix expected = covariance(effects, scales).ldlt().solve(X);
    const RandomWeights weights(effects, scales);
    const Matrix root = weights.stacked(X);
    EXPECT_EQ(root.rows(), 24 + weights.more_rows());
    EXPECT_LT((root.transpose() * root - X.transpose() * expected).norm(), 1e-9);
    EXPECT_LT((weights.inverse(X) - expected).norm(), 1e-9);
  }
}

TEST(Widening, IsOneOnTheMeanWhereTheCovarianceIsTrue) {
  // Forty windows; residuals drawn by their covariance.
  RandomEffects effects = small_effects(6, 2);
  const RandomBlock like = effects.blocks.front();
  effects.blocks.assign(40, like);
  for (int w = 0; w < 40; ++w) effects.blocks[w].first = 6 * w;
  Whitening whitening;
  whitening.rows = 240;
  whitening.random = effects;
  Fit fit;
  fit.scales = Vector{{0.7, 0.4}};
  fit.jacobian = Matrix(normal_matrix(240, 1, 32).array() + 0.5);
  const Eigen::LLT<Matrix> V(covariance(effects, fit.scales));
  const Matrix H = fit.jacobian.transpose() * V.solve(fit.jacobian) + Matrix::Identity(1, 1);
  fit.covariance = H.inverse();

  double squares = 0.0, repeated = 0.0;
  const int draws = 300;
  for (int i = 0; i < draws; ++i) {
    fit.residual = V.matrixL() * normal_matrix(240, 1, 1000 + i);
    squares += std::pow(widening(whitening, fit, Vector::Unit(fit.jacobian.cols(), 0)), 2) / draws;
    // A misfit that goes the same way in every window widens.
    fit.residual += 0.8 * fit.jacobian.col(0).cwiseAbs2();
    repeated += std::pow(widening(whitening, fit, Vector::Unit(fit.jacobian.cols(), 0)), 2) / draws;
  }
  // At least 1 each, of ratios that scatter by sqrt(2/40) about 1.
  EXPECT_NEAR(squares, 1.0 + std::sqrt(2.0 / 40.0) / std::sqrt(2.0 * std::numbers::pi), 0.06);
  EXPECT_GT(repeated, 1.5);
}

TEST(Columns, SideBySideAndMovedHaveTheProductsOfTheWhole) {
  const RandomEffects effects = small_effects(12, 4);
  const Columns a = columns_of(effects, normal_matrix(24, 3, 21)),
                b = columns_of(effects, normal_matrix(24, 2, 22)),
                moved = columns_of(effects, normal_matrix(24, 1, 23));
  const auto expect_products = [&](const Products& built, const Matrix& X) {
    const Products whole = products_of(effects, X);
    EXPECT_LT((built.gram - whole.gram).norm(), 1e-10);
    ASSERT_EQ(built.blocks.size(), whole.blocks.size());
    for (std::size_t i = 0; i < whole.blocks.size(); ++i)
      EXPECT_LT((built.blocks[i] - whole.blocks[i]).norm(), 1e-10);
  };
  const Columns both = side_by_side(effects, a, b);
  EXPECT_EQ(both.X.rightCols(2), b.X);
  expect_products(both.products, both.X);

  Matrix X = a.X;
  X.col(0) += moved.X;
  expect_products(first_moved(a.products, products_between(effects, a.X, moved.X), moved.products),
                  X);
}

TEST(RandomEffects, DeviationsThatWerePlantedComeBack) {
  const RandomEffects effects = small_effects(400, 160);
  Vector y = normal_matrix(800, 1, 5);
  const Vector w = normal_matrix(320, 1, 6);
  for (int b = 0; b < 2; ++b)
    for (int k = 0; k < 160; ++k)
      if (effects.blocks[b].group[k] == 0)
        y.segment(400 * b, 400) += 2.0 * w[160 * b + k] * effects.blocks[b].columns.col(k);

  const Products products = products_of(effects, y);
  const ScaleEstimate estimate =
      estimated_scales(effects, products, first_scales(effects), 50, 2.3);
  EXPECT_NEAR(estimate.scales[0], 2.0, 0.25);  // of 160 boxes: 6 %
  // Nothing was planted in the other: what it takes is no more than the noise lets it.
  EXPECT_LT(estimate.scales[1], 0.05);
  EXPECT_LT(estimate.log_cost, 0.0);

  // At the maximum: less evidence to either side.
  const auto evidence = [&](double factor) {
    Vector scales = estimate.scales;
    scales[0] *= factor;
    return linear_evidence(effects, products, scales).log_evidence;
  };
  EXPECT_GT(evidence(1.0), evidence(1.15));
  EXPECT_GT(evidence(1.0), evidence(0.85));
}

TEST(RandomEffects, AGroupIsNotQuieterThanTheSlowerOneBeforeIt) {
  RandomEffects effects = small_effects(400, 160);
  Vector w = normal_matrix(320, 1, 6);
  const auto planted = [&](double a, double b) {
    Vector y = normal_matrix(800, 1, 5);
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < 160; ++k)
        y.segment(400 * i, 400) += (effects.blocks[i].group[k] == 0 ? a : b) * w[160 * i + k] *
                                   effects.blocks[i].columns.col(k);
    return estimated_scales(effects, products_of(effects, y), first_scales(effects), 50, 2.3);
  };
  effects.groups[1].slower = 0;
  const ScaleEstimate rising = planted(0.5, 2.0), falling = planted(2.0, 0.5);
  EXPECT_NEAR(rising.scales[0], 0.5, 0.07);
  EXPECT_NEAR(rising.scales[1], 2.0, 0.25);

  // As many of each: the root mean square of both.
  EXPECT_EQ(falling.scales[0], falling.scales[1]);
  EXPECT_NEAR(falling.scales[0], std::sqrt(0.5 * (4.0 + 0.25)), 0.2);
}

TEST(RandomEffects, MoreSamplesOfTheSameForceAddLittleEvidence) {
  // One box of force seen by 10 or by 1,000 rows: beyond what tells the box itself, samples tell
  // nothing of whether a force is missing.
  double gain[2];
  for (int i = 0; i < 2; ++i) {
    const int rows = i == 0 ? 10 : 1000;
    RandomEffects effects;
    effects.groups = {{"force", 0}};
    RandomBlock block{0, rows, Matrix::Constant(rows, 1, 10.0), {0}, {}};
    block.gram = block.columns.transpose() * block.columns;
    effects.blocks = {block};
    const Products products = products_of(effects, 3.0 * block.columns);
    const ScaleEstimate estimate =
        estimated_scales(effects, products, first_scales(effects), 50, 2.3);
    const double with = linear_evidence(effects, products, estimate.scales).log_evidence;
    // A model that leaves a tenth of that force.
    const Products less = products_of(effects, 0.3 * block.columns);
    const ScaleEstimate smaller = estimated_scales(effects, less, first_scales(effects), 50, 2.3);
    gain[i] = linear_evidence(effects, less, smaller.scales).log_evidence - with;
  }
  EXPECT_NEAR(gain[0], std::log(10.0), 0.3);  // one box, ten times smaller
  EXPECT_NEAR(gain[1], gain[0], 0.3);
}

}  // namespace
}  // namespace jaculus::diagnosis
