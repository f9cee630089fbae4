// L D L^T along time against Eigen's dense decompositions: solutions, inertia, and that a pivot
// that is not there yet is put off.

#include "solver/frontal.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "jaculus/core/types.h"
#include "solver/ipopt_frontal.h"

namespace jaculus::solver {
namespace {

/// A symmetric matrix as Ipopt would hand it over, with the numbers of its unknowns.
struct Kkt {
  SymmetricPattern pattern;
  std::vector<double> values;
  detail::KktSizes sizes;

  void add(int row, int column, double value) {
    pattern.rows.push_back(row);
    pattern.columns.push_back(column);
    values.push_back(value);
  }
  [[nodiscard]] Matrix dense() const {
    Matrix full = Matrix::Zero(pattern.size, pattern.size);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const int i = pattern.rows[k], j = pattern.columns[k];
      full(i, j) += values[k];
      if (i != j) full(j, i) += values[k];
    }
    return full;
  }
};

constexpr int kStates = 3, kInputs = 2, kSteps = 7, kNode = kStates + kInputs;

/// A chain of steps, states then inputs, one duration at the end; defects between the steps and two
/// inequality rows a step. `curvature` scales the Hessian, `slack` are the weights of the slacks.
Kkt chain(unsigned seed, double curvature, const std::vector<double>& slack) {
  std::mt19937 random(seed);
  std::normal_distribution<double> number;
  Kkt kkt;
  const int x = kSteps * kNode + 1, s = 2 * (kSteps - 1), y_c = kStates * (kSteps - 1);
  kkt.sizes = {x, s, y_c};
  kkt.pattern.size = x + 2 * s + y_c;
  for (int i = 0; i < s; ++i)
    kkt.add(x + i, x + i, slack[static_cast<std::size_t>(i) % slack.size()]);

  for (int k = 0; k + 1 < kSteps; ++k) {
    std::vector<int> reads{x - 1};
    for (int i = 0; i < 2 * kNode; ++i) reads.push_back(k * kNode + i);
    for (std::size_t i = 0; i < reads.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        kkt.add(std::max(reads[i], reads[j]), std::min(reads[i], reads[j]),
                curvature * number(random));
    const auto add_row = [&](int y) {
      for (const int column : reads) kkt.add(y, column, number(random));
    };
    for (int i = 0; i < kStates; ++i) add_row(x + s + k * kStates + i);
    for (int i = 0; i < 2; ++i) {
      const int row = 2 * k + i;
      add_row(x + s + y_c + row);
      kkt.add(x + s + y_c + row, x + row, -1.0);
    }
  }
  return kkt;
}

void expect_solved(const Kkt& kkt, double tolerance) {
  const Matrix full = kkt.dense();
  FrontalFactorization frontal(kkt.pattern, detail::order_along_time(kkt.pattern, kkt.sizes));
  EXPECT_LE(frontal.widest_front(), 2 * kNode + kStates + 1);

  const Inertia inertia = frontal.factorize(kkt.values, 1e-2);
  const Vector eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix>(full).eigenvalues();
  EXPECT_EQ(inertia.negative, (eigenvalues.array() < 0.0).count());
  EXPECT_EQ(inertia.zero, 0);

  const Vector expected = Vector::LinSpaced(full.rows(), -1.0, 2.0);
  Vector x = full * expected;
  frontal.solve({x.data(), static_cast<std::size_t>(x.size())});
  EXPECT_LT((x - expected).cwiseAbs().maxCoeff(), tolerance);
}

TEST(Frontal, SolvesAndCountsNegativeEigenvaluesOfIndefiniteChains) {
  for (unsigned seed = 1; seed <= 20; ++seed) expect_solved(chain(seed, 1.0, {1.0, 0.3}), 1e-8);
}

TEST(Frontal, PutsOffAPivotThatIsZeroWhenItsGroupEnds) {
  // [0 2 0; 2 0 1; 0 1 3], a group an unknown: the first has no pivot before the second is there.
  FrontalFactorization frontal({3, {1, 2, 2}, {0, 1, 2}}, {{0, 1, 2}, {}, 3});
  const Inertia inertia = frontal.factorize(std::vector<double>{2.0, 1.0, 3.0}, 1e-2);
  EXPECT_EQ(inertia.negative, 1);
  EXPECT_EQ(inertia.zero, 0);

  std::vector<double> x = {2.0 * 5.0, 2.0 * 4.0 + 6.0, 5.0 + 3.0 * 6.0};  // of (4, 5, 6)
  frontal.solve(x);
  EXPECT_NEAR(x[0], 4.0, 1e-12);
  EXPECT_NEAR(x[1], 5.0, 1e-12);
  EXPECT_NEAR(x[2], 6.0, 1e-12);
}

TEST(Frontal, KeepsTheDigitsWhereSlacksAreAsStiffAsNearTheSolution) {
  for (unsigned seed = 1; seed <= 10; ++seed)
    expect_solved(chain(seed, 1.0, {1e-9, 1e7, 1e12}), 1e-6);
}

TEST(Frontal, CountsAColumnThatNothingReadsAsZero) {
  Kkt kkt = chain(5, 1.0, {1.0});
  for (std::size_t k = 0; k < kkt.values.size(); ++k)
    if (kkt.pattern.rows[k] == 4 || kkt.pattern.columns[k] == 4) kkt.values[k] = 0.0;
  FrontalFactorization frontal(kkt.pattern, detail::order_along_time(kkt.pattern, kkt.sizes));
  EXPECT_EQ(frontal.factorize(kkt.values, 1e-2).zero, 1);
}

}  // namespace
}  // namespace jaculus::solver
