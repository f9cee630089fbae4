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

  /// All rows are moved by these forces of one deviation, none belongs to a misfit.
  void have_forces_alone(const Matrix& forces) {
    random = {};
    random.groups = {{.name = "elbow", .force = 0}};
    const std::vector<int> group(forces.cols(), 0);
    random.blocks = {{0, kForemostRows, forces, group, forces.transpose() * forces}};
    table.products = products_of(random, X);
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

TEST(ForemostSets, CountWhatForcesMayExplainAsNoEffect) {
  // What is strongest in the data lies along forces that the model may lack; candidates 1 and 4 do
  // less, and nothing else does it.
  Matrix X = columns_without_residual();
  const Matrix forces = normal_matrix(kForemostRows, 3, 11);
  X.col(column_of(2)) = forces.col(0) + 0.1 * normal_matrix(kForemostRows, 1, 12);
  X.col(0) += 2.0 * forces.col(0) + 0.2 * X.col(column_of(1)) - 0.2 * X.col(column_of(4));
  Linear linear(X);
  linear.have_forces_alone(forces);
  const Vector large = Vector{{20.0}}, small = Vector{{1e-3}};

  std::vector<Members> best = larger_sets({}, kForemostCandidates, 2);
  std::erase_if(best, [](const Members& set) { return set.size() == 1; });
  const std::vector<Members> pairs = best;
  const auto evidence = [&](const Members& set) {
    Matrix own(kForemostRows, 1 + count_of(set) + kForemostNuisances);
    own << X.col(0), X.col(column_of(set[0])), X.col(column_of(set[1])),
        X.middleCols(1, kForemostNuisances);
    return linear_evidence(linear.random, products_of(linear.random, own), large).log_evidence;
  };
  std::sort(best.begin(), best.end(),
            [&](const Members& a, const Members& b) { return evidence(a) > evidence(b); });
  EXPECT_EQ(best.front(), (Members{1, 4}));
  best.resize(5);
  std::sort(best.begin(), best.end());
  EXPECT_EQ(linear.foremost(5, pairs, large), best);
  // Without forces candidate 2 is needed.
  for (const Members& set : linear.foremost(3, pairs, small))
    EXPECT_TRUE(std::binary_search(set.begin(), set.end(), 2));
}

TEST(ForemostSets, CountForcesThatASetMakesNeedlessAsSmaller) {
  // At the fit forces do what candidate 2 does; at their deviation there it gains next to nothing.
  // Candidate 4 does a little where no force acts.
  Matrix X = columns_without_residual();
  const Matrix forces = normal_matrix(kForemostRows, 3, 11);
  X.col(column_of(2)) = 4.0 * forces.col(0);
  X.col(0) += X.col(column_of(2)) + 0.1 * X.col(column_of(4));
  Linear linear(X);
  linear.have_forces_alone(forces);
  const auto evidence = [&](int candidate, double deviation) {
    Matrix own(kForemostRows, 2 + kForemostNuisances);
    own << X.col(0), X.col(column_of(candidate)), X.middleCols(1, kForemostNuisances);
    const Products products = products_of(linear.random, own);
    return linear_evidence(linear.random, products, Vector{{deviation}}).log_evidence;
  };
  ASSERT_LT(evidence(2, 4.0), evidence(4, 4.0));
  ASSERT_GT(evidence(2, 0.4), std::max(evidence(4, 4.0), evidence(4, 0.4)));
  EXPECT_EQ(linear.foremost(1, {{2}, {4}}, Vector{{4.0}}), (std::vector<Members>{{2}}));
}

TEST(ForemostSets, HaveForcesInSomeRowsAndMisfitsInOthers) {
  // Forces move the first half of the rows, of which none belongs to a misfit; candidate 3 does in
  // the second half what the misfit there would have to.
  Matrix X = columns_without_residual();
  const int half = kForemostRows / 2;
  const Matrix forces = normal_matrix(half, 2, 13);
  X.col(column_of(2)).head(half) = forces.col(0);
  X.col(column_of(2)).tail(half).setZero();
  X.col(0).head(half) += 2.0 * forces.col(0);
  X.col(0) += 0.4 * X.col(column_of(3));
  Linear linear(X);
  linear.random.groups[0] = {.name = "elbow", .force = 0};
  linear.random.misfits.erase(linear.random.misfits.begin());
  linear.random.blocks = {{0, half, forces, {0, 0}, forces.transpose() * forces}};
  linear.table.products = products_of(linear.random, X);
  const Vector scales = Vector{{20.0, 0.5}};

  std::vector<Members> singles = larger_sets({}, kForemostCandidates, 1), best = singles;
  const auto worth = [&](const Members& set) {
    double most = -kInfinity;
    for (const double deviation : {20.0, 20.0 / 3.0, 2.0}) {
      const Matrix V =
          Matrix::Identity(2, 2) + deviation * deviation * linear.random.blocks.front().gram;
      most = std::max(most, worth_alone(linear, set, Vector{{deviation, 0.5}}) -
                                0.5 * std::log(V.determinant()));
    }
    return most;
  };
  std::sort(best.begin(), best.end(),
            [&](const Members& a, const Members& b) { return worth(a) > worth(b); });
  EXPECT_EQ(best.front(), (Members{3}));
  best.resize(2);
  std::sort(best.begin(), best.end());
  EXPECT_EQ(linear.foremost(2, singles, scales), best);
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
