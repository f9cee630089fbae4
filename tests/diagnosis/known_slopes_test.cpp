// Fits near another, by slopes that are known.

#include "diagnosis/selection/known_slopes.h"

#include <gtest/gtest.h>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/fit.h"
#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kMoves = 0.05;  ///< by how much a unit of the tolerance moves what `first` moves
constexpr double kOfScale = 2.0;
constexpr int kToleranceAt = 4;

/// The toy with a tolerance that does what `first` does, and a part of what `second` does.
std::shared_ptr<Problem> tolerant_toy(double first, double second) {
  auto problem = test::toy_problem(test::toy_truth(first, second));
  problem->hypotheses.parameters.push_back(
      {"tolerance", "shape", "units", 0.0, kOfScale, {-4.0, 4.0}});
  problem->hypotheses.tolerances = {kToleranceAt};
  problem->forward = [](int, int, const Vector& p) {
    Vector all = p.head(4);
    all[0] += kMoves * p[kToleranceAt];
    all[1] += 0.1 * kMoves * p[kToleranceAt];
    return test::toy_prediction(all);
  };
  return problem;
}

/// All parameters without `first`: as another fit has them, and as the one with it expects them.
struct Without {
  Vector fitted, expected;
};
Without without_first(double first, double second) {
  const auto problem = tolerant_toy(first, second);
  const Hypotheses& hypotheses = problem->hypotheses;
  const Vector nominal = hypotheses.nominal();
  const Comparison comparison = comparison_about(*problem, estimate_noise(*problem, nominal));
  const auto fitted = [&](const std::vector<int>& members) {
    FitOptions options;
    options.hold_scales = true;
    options.scales = Vector::Zero(comparison.whitening.random.size());
    const Fit fit =
        fit_model(*problem, comparison.whitening, hypotheses.freed_by(members), {nominal}, options);
    EXPECT_TRUE(fit.valid) << fit.message;
    return fit;
  };
  return {fitted({1}).p, optimum_without(*problem, comparison.whitening, fitted({1, 0}), {0})};
}

TEST(OptimumWithout, IsThatOfTheSmallerModelWhereAllIsLinear) {
  const Without small = without_first(0.12, 0.02);
  EXPECT_GT(small.fitted[kToleranceAt], 1.5);  // it does what the effect did
  EXPECT_NEAR(small.expected[kToleranceAt], small.fitted[kToleranceAt], 0.02);
  EXPECT_NEAR(small.expected[1], small.fitted[1], 2e-4);
  EXPECT_GT(std::abs(small.fitted[1] - 0.02), 2e-3);  // and the other effect makes up for it
  EXPECT_EQ(small.expected[0], 0.0);
}

TEST(OptimumWithout, LeavesToOthersWhatABoundCuts) {
  const Without small = without_first(0.4, 0.02);
  EXPECT_EQ(small.fitted[kToleranceAt], 4.0);
  EXPECT_EQ(small.expected[kToleranceAt], 4.0);
  EXPECT_NEAR(small.expected[1], small.fitted[1], 2e-3);
}

}  // namespace
}  // namespace jaculus::diagnosis
