// The foremost of many sets, beside what is worked out for each alone.

#include "diagnosis/selection/foremost_sets.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "diagnosis/noise/random_weights.h"
#include "diagnosis/normal_matrix.h"
#include "diagnosis/selection/minimise.h"
#include "diagnosis/selection/neighbouring_sets.h"
#include "diagnosis/selection/posterior.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kForemostRows = 60, kForemostNuisances = 4, kForemostCandidates = 6;

/// Columns [r0 N Y] of two coordinates whose misfits count as six values each.
struct Linear {
  RandomEffects random;
  Matrix X;
  SetProducts table;
  Problem problem;

  explicit Linear(Matrix columns) : X(std::move(columns)) {
    const int half = kForemostRows / 2;
    random.groups = {{"misfit of a"}, {"misfit of b"}};
    random.misfits = {{0, 6.0, double(half), {{0, half}}}, {1, 6.0, double(half), {{half, half}}}};
    table.products = products_of(random, X);
    for (Eigen::Index i = 0; i < kForemostNuisances; ++i) table.nuisances.push_back(1 + i);
    for (int c = 0; c < kForemostCandidates; ++c) {
      table.own.push_back({1 + kForemostNuisances + c});
      problem.hypotheses.parameters.push_back({});
      problem.hypotheses.candidates.push_back({"effect", {}, {c}, nullptr});
    }
  }

  [[nodiscard]] std::vector<Members> foremost(int count, const std::vector<Members>& sets,
                                              const Vector& scales) {
    problem.settings.sets_followed = count;
    return foremost_sets(problem, random, scales, table, sets);
  }
};

/// Noise, nuisances and candidates of plain strength; the first column is for r0.
Matrix columns_without_residual() {
  Matrix X = 3.0 * normal_matrix(kForemostRows, 1 + kForemostNuisances + kForemostCandidates, 7);
  X.col(0) = normal_matrix(kForemostRows, 1, 8);
  return X;
}

Eigen::Index column_of(int candidate) { return 1 + kForemostNuisances + candidate; }

/// What a set is worth by its own least squares at some scales and the misfits that these leave.
double worth_alone(const Linear& linear, const Members& set, const Vector& scales) {
  const int n = count_of(set) + kForemostNuisances;
  Matrix own(kForemostRows, n);
  for (int k = 0; k < count_of(set); ++k) own.col(k) = linear.X.col(column_of(set[k]));
  own.rightCols(kForemostNuisances) = linear.X.middleCols(1, kForemostNuisances);
  const RandomWeights weights(linear.random, scales);
  const Matrix A = Matrix::Identity(n, n) + own.transpose() * weights.inverse(own);
  const Vector u = A.llt().solve(own.transpose() * weights.inverse(linear.X.col(0)));
  const Vector r = linear.X.col(0) - own * u;
  const double shared = A.bottomRightCorner(kForemostNuisances, kForemostNuisances).determinant();
  return -cost_of(linear.random, scales, Misfits::follow, r, u) -
         0.5 * std::log(A.determinant() / shared) +
         log_prior(set.size(), kForemostCandidates, linear.problem.settings);
}

TEST(ForemostSets, AreThoseThatLeastSquaresOfEachPutFirst) {
  Matrix X = columns_without_residual();
  X.col(0) += 0.5 * X.col(column_of(1)) - 0.3 * X.col(column_of(4)) + 0.4 * X.col(2);
  Linear linear(X);
  const std::vector<Members> sets = larger_sets({}, kForemostCandidates, 2);
  for (const Vector& scales : {complete_scales(linear.random), Vector(Vector{{2.0, 0.5}})}) {
    std::vector<Members> best = sets;
    std::stable_sort(best.begin(), best.end(), [&](const Members& a, const Members& b) {
      return worth_alone(linear, a, scales) > worth_alone(linear, b, scales);
    });
    EXPECT_EQ(best.front(), (Members{1, 4}));
    std::stable_partition(best.begin(), best.end(),
                          [](const Members& set) { return set.size() == 2; });
    best.resize(5);
    std::vector<Members> found = linear.foremost(5, sets, scales);
    EXPECT_EQ(found.front().size(), 1U);  // as they stood
    std::erase_if(best, [](const Members& set) { return set.size() == 1; });
    std::erase_if(found, [](const Members& set) { return set.size() == 1; });
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
    std::sort(best.begin(), best.end());
    EXPECT_EQ(found, best);
  }
}

TEST(ForemostSets, HoldTwoOfWhichNeitherHelpsWithoutTheOther) {
  // What they do together is at right angles to either.
  Matrix X = columns_without_residual();
  const Vector small = normal_matrix(kForemostRows, 1, 9);
  X.col(column_of(3)) = 40.0 * X.col(column_of(0)) + small;
  X.col(column_of(0)) *= 40.0;
  X.col(0) += 2.0 * small;
  Linear linear(X);
  std::vector<Members> pairs = larger_sets({}, kForemostCandidates, 2);
  std::erase_if(pairs, [](const Members& set) { return set.size() == 1; });
  const auto found = linear.foremost(1, pairs, complete_scales(linear.random));
  EXPECT_EQ(found, (std::vector<Members>{{0, 3}}));
}

TEST(ForemostSets, AreJudgedByTheMisfitsThatTheyLeave) {
  // By the misfit of all that is there the second coordinate hardly counts; candidate 2 explains
  // the first, candidate 5 the second.
  Matrix X = columns_without_residual();
  const int half = kForemostRows / 2;
  X.col(column_of(2)).tail(half).setZero();
  X.col(column_of(5)).head(half).setZero();
  X.col(0) += 0.9 * X.col(column_of(2)) + X.col(column_of(5));
  Linear linear(X);
  const Vector large = Vector{{0.1, 3.0}};
  EXPECT_EQ(linear.foremost(1, {{1, 2}, {2, 4}, {2, 5}, {3, 5}}, large),
            (std::vector<Members>{{2, 5}}));
}

TEST(ForemostSets, HoldNoneThatWouldHaveToWorkTheWrongWay) {
  Matrix X = columns_without_residual();
  X.col(0) += 0.5 * X.col(column_of(1)) - 0.3 * X.col(column_of(4));
  Linear linear(X);
  FreeParameter& own = linear.problem.hypotheses.parameters[4];
  own.bounds = {own.nominal, kInfinity};
  const Vector scales = complete_scales(linear.random);
  EXPECT_EQ(linear.foremost(1, {{1, 4}, {1, 2}}, scales), (std::vector<Members>{{1, 2}}));
  own.bounds = {-kInfinity, own.nominal};
  EXPECT_EQ(linear.foremost(1, {{1, 4}, {1, 2}}, scales), (std::vector<Members>{{1, 4}}));
}

TEST(ForemostSets, AreAllWhereTheyAreFewAndKeepTheirOrder) {
  Linear linear(columns_without_residual());
  const std::vector<Members> sets = {{3}, {0}, {1, 2}};
  EXPECT_EQ(linear.foremost(3, sets, complete_scales(linear.random)), sets);
}

}  // namespace
}  // namespace jaculus::diagnosis
