// Misfits of datasets under a plan: densities in closed form, sizes that were planted, and that a
// fit is by least squares.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "diagnosis/noise/columns.h"
#include "diagnosis/noise/random_effects.h"
#include "diagnosis/noise/random_weights.h"
#include "diagnosis/normal_matrix.h"
#include "diagnosis/selection/minimise.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kMisfitRows = 40;
constexpr double kMisfitValues = 6.0;

/// Two datasets whose rows take turns: two spans of each.
RandomEffects two_datasets(int rows = kMisfitRows) {
  RandomEffects effects;
  effects.groups = {{"misfit of a"}, {"misfit of b"}};
  const int half = rows / 2;
  effects.misfits = {{0, kMisfitValues, double(rows), {{0, half}, {2 * half, half}}},
                     {1, kMisfitValues, double(rows), {{half, half}, {3 * half, half}}}};
  return effects;
}

/// E of a misfit.
double misfit_energy(const Misfit& own, const Vector& r) {
  double sum = 0.0;
  for (const auto& [first, count] : own.spans) sum += r.segment(first, count).squaredNorm();
  return sum;
}

TEST(Misfits, TheMostLikelyOnesCostTheLogarithmOfTheEnergyBeyondNoise) {
  const RandomEffects effects = two_datasets();
  Vector r = normal_matrix(2 * kMisfitRows, 1, 1);
  for (const auto& [first, count] : effects.misfits[0].spans) r.segment(first, count) *= 5.0;
  for (const auto& [first, count] : effects.misfits[1].spans) r.segment(first, count) *= 0.5;

  // The first is far off; of the second less is left than noise makes.
  const double beyond = misfit_energy(effects.misfits[0], r) - kMisfitRows;
  const double expected = kMisfitValues * std::log1p(beyond / kMisfitValues) + kMisfitRows +
                          misfit_energy(effects.misfits[1], r);
  const Vector none(0);
  EXPECT_NEAR(2.0 * cost_of(effects, Vector::Zero(2), Misfits::follow, r, none), expected, 1e-9);

  // No other size is likelier.
  const Vector likely = misfits_of(effects, r, Vector::Zero(2));
  EXPECT_EQ(likely[1], 0.0);
  for (const double factor : {0.9, 0.99, 1.01, 1.1})
    EXPECT_GT(2.0 * cost_of(effects, Vector{{factor * likely[0], 0.0}}, Misfits::held, r, none) +
                  misfits_log_det(effects, Vector{{factor * likely[0], 0.0}}),
              expected);
}

TEST(Misfits, WeighRowsAsWeightsDo) {
  const RandomEffects effects = two_datasets();
  const Vector scales{{2.0, 0.3}};
  const Matrix X = normal_matrix(2 * kMisfitRows, 3, 2);
  const RandomWeights weights(effects, scales);
  const Weighed weighed = weigh(effects, products_of(effects, X), scales);
  EXPECT_LT((X.transpose() * weights.inverse(X) - weighed.gram).norm(), 1e-10);
  EXPECT_LT((weights.stacked(X).transpose() * weights.stacked(X) - weighed.gram).norm(), 1e-10);
  EXPECT_NEAR(misfits_log_det(effects, scales), weighed.log_det, 1e-12);
}

TEST(Misfits, SidesAndMovesHaveTheProductsOfTheWhole) {
  const RandomEffects effects = two_datasets();
  const Columns a = columns_of(effects, normal_matrix(2 * kMisfitRows, 3, 3)),
                b = columns_of(effects, normal_matrix(2 * kMisfitRows, 2, 4)),
                moved = columns_of(effects, normal_matrix(2 * kMisfitRows, 1, 5));
  const auto expect_products = [&](const Products& built, const Matrix& X) {
    const Products whole = products_of(effects, X);
    EXPECT_LT((built.gram - whole.gram).norm(), 1e-10);
    ASSERT_EQ(built.misfits.size(), whole.misfits.size());
    for (std::size_t c = 0; c < whole.misfits.size(); ++c)
      EXPECT_LT((built.misfits[c] - whole.misfits[c]).norm(), 1e-10);
  };
  const Columns both = side_by_side(effects, a, b);
  expect_products(both.products, both.X);

  Matrix X = a.X;
  X.col(0) += moved.X;
  const Across across = products_between(effects, a.X, moved.X);
  expect_products(first_moved(a.products, across, moved.products), X);

  // Of some columns, and of more behind them.
  const Across all = products_between(effects, a.X, both.X);
  const Across again = all.of(0, 3).with(all.of(3, 2));
  EXPECT_EQ(again.gram, all.gram);
  EXPECT_EQ(again.misfits.back(), all.misfits.back());
}

TEST(Misfits, ThatWerePlantedComeBack) {
  const RandomEffects effects = two_datasets(4000);
  Vector r = normal_matrix(8000, 1, 6);
  // A misfit of 3 noise floors in the first, the same in both spans.
  for (const auto& [first, count] : effects.misfits[0].spans)
    r.segment(first, count).array() += 3.0;
  const ScaleEstimate estimate =
      estimated_scales(effects, products_of(effects, r), first_scales(effects), 50, 2.3);
  EXPECT_NEAR(estimate.scales[0], 3.0, 0.1);
  EXPECT_LT(estimate.scales[1], 0.3);
}

TEST(Misfits, AreNotBelowTheirLeast) {
  // Two models that leave 80 and 90 % of the noise's energy, of 4,000 rows: told apart by 200 nats
  // of details of the noise, or by little where any model may be off by a part of it.
  RandomEffects effects = two_datasets(2000);
  const Vector none(0), more = std::sqrt(0.9) * normal_matrix(4000, 1, 8),
                        less = std::sqrt(0.8 / 0.9) * more;
  const auto gain = [&] {
    return cost_of(effects, Vector::Zero(2), Misfits::follow, more, none) -
           cost_of(effects, Vector::Zero(2), Misfits::follow, less, none);
  };
  EXPECT_NEAR(gain(), 0.5 * 0.1 * 4000.0, 10.0);

  for (RandomGroup& group : effects.groups) group.least = 0.3;
  const double variance = effects.misfits[0].variance(0.3);
  EXPECT_DOUBLE_EQ(variance, 1.0 + 0.09 * 2000.0 / kMisfitValues);
  EXPECT_NEAR(gain(), 0.5 * 0.1 * 4000.0 / variance, 0.5);
  EXPECT_EQ(complete_scales(effects), Vector::Constant(2, 0.3));
}

TEST(Misfits, AtTheirLeastCostNothing) {
  RandomEffects effects = two_datasets(2000);
  for (RandomGroup& group : effects.groups) group.least = 0.3;
  Vector r = normal_matrix(4000, 1, 10);
  const auto cost = [&] {
    return estimated_scales(effects, products_of(effects, r), first_scales(effects), 50, 2.3)
        .log_cost;
  };
  EXPECT_EQ(cost(), 0.0);

  // One that is chosen costs its own, whatever the other does.
  for (const auto& [first, count] : effects.misfits[0].spans)
    r.segment(first, count).array() += 30.0;
  EXPECT_NEAR(cost(), -0.5 * std::log(1.0 + 2.0 * 2.3 * 2.3 * kMisfitValues), 0.01);
}

TEST(Misfits, MoreSamplesOfTheSameMisfitAddLittleEvidence) {
  // A model that leaves a tenth of a misfit gains n log(10) whether 40 rows say so or 4,000.
  for (const int rows : {kMisfitRows, 100 * kMisfitRows}) {
    const RandomEffects effects = two_datasets(rows);
    const auto evidence = [&](double misfit) {
      const Products products = products_of(effects, Vector::Constant(2 * rows, misfit));
      const ScaleEstimate estimate =
          estimated_scales(effects, products, first_scales(effects), 50, 2.3);
      return linear_evidence(effects, products, estimate.scales).log_evidence;
    };
    EXPECT_NEAR(evidence(30.0) - evidence(300.0), 2.0 * kMisfitValues * std::log(10.0), 0.1);
  }
}

TEST(Misfits, ACoordinateThatNothingExplainsDoesNotOutvoteTheOthers) {
  // The first is off by 1,000 noise floors, whatever u, and asks for u = 5 by the way; the second
  // is explained by u = 1.
  Matrix X = normal_matrix(2 * kMisfitRows, 2, 9);
  const RandomEffects own = two_datasets();
  for (const auto& [first, count] : own.misfits[0].spans) {
    const Vector slopes = 2000.0 * Vector::Unit(count, 0);
    X.col(1).segment(first, count) = slopes;
    X.col(0).segment(first, count) = 5.0 * slopes + 1000.0 * Vector::Unit(count, 1);
  }
  for (const auto& [first, count] : own.misfits[1].spans) {
    X.col(1).segment(first, count).setConstant(3.0);
    X.col(0).segment(first, count).array() += 3.0;
  }
  const auto likely = [&](const RandomEffects& effects) {
    const Products products = products_of(effects, X);
    const ScaleEstimate estimate =
        estimated_scales(effects, products, first_scales(effects), 50, 2.3);
    return linear_evidence(effects, products, estimate.scales).mean[0];
  };
  EXPECT_NEAR(likely(own), 1.0, 0.15);

  // One size for both would let it.
  RandomEffects common;
  common.groups = {{"misfit"}};
  common.misfits = {{0, 2.0 * kMisfitValues, 2.0 * kMisfitRows, {{0, 2 * kMisfitRows}}}};
  EXPECT_NEAR(likely(common), 5.0, 0.3);
}

TEST(Misfits, WhatModelsShareIsNotMarginalised) {
  // Two models of the same residual whose shared columns differ in size alone: how well data tell
  // these is no evidence.
  const RandomEffects effects = two_datasets();
  Matrix X = normal_matrix(2 * kMisfitRows, 3, 7);
  X.rightCols(2) *= 50.0;
  Products products = products_of(effects, X);
  products.shared = {0, 1};
  const LinearEvidence shared = linear_evidence(effects, products, Vector::Zero(2));
  const Matrix A = X.rightCols(2).transpose() * X.rightCols(2) + Matrix::Identity(2, 2);
  const Vector left = X.col(0) - X.rightCols(2) * shared.mean;
  EXPECT_NEAR(shared.log_evidence, -0.5 * (left.squaredNorm() + shared.mean.squaredNorm()), 1e-8);

  products.shared.clear();
  EXPECT_NEAR(linear_evidence(effects, products, Vector::Zero(2)).log_evidence,
              shared.log_evidence - 0.5 * std::log(A.determinant()), 1e-8);
}

}  // namespace
}  // namespace jaculus::diagnosis
