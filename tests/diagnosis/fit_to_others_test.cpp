// A model fitted to one condition to predict another: where these differ, slopes of the fit to both
// do not lead there.

#include "diagnosis/validation/fit_to_others.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/toy.h"
#include "diagnosis/validation/held_out.h"

namespace jaculus::diagnosis {
namespace {

using test::toy_problem;
using test::toy_truth;

constexpr int kStrength = 1;  // index of the parameter
// Of that parameter, a condition each.
constexpr std::array<double, 2> kStrengthOf = {-0.4, 0.5};

/// Of the second effect's strength: slopes at 0.5 are six times those at -0.4.
double strength(double p) { return std::exp(2.0 * p) - 1.0; }

struct TwoConditions {
  std::shared_ptr<Problem> problem;
  std::shared_ptr<std::array<std::atomic<int>, 2>> simulated =
      std::make_shared<std::array<std::atomic<int>, 2>>();

  TwoConditions() : problem(toy_problem(toy_truth(0.0, strength(kStrengthOf[0])))) {
    test::ToyData other;
    other.seed = 2;
    problem->observations.datasets.push_back(
        toy_problem(toy_truth(0.0, strength(kStrengthOf[1])), other)->observations.datasets[0]);
    problem->forward = [counts = simulated](int dataset, int, const Vector& p) {
      ++(*counts)[dataset];
      return test::toy_prediction(toy_truth(0.0, strength(p[kStrength])));
    };
  }
};

struct FittedToBoth {
  TwoConditions two;
  Vector nominal = two.problem->hypotheses.nominal();
  Comparison comparison = comparison_about(*two.problem, estimate_noise(*two.problem, nominal));
  Fit fit = fit_model(*two.problem, comparison.whitening, {kStrength}, {nominal});
};

SegmentMask without(const Problem& problem, int left_out) {
  SegmentMask mask;
  for (int d = 0; d < 2; ++d)
    mask.emplace_back(problem.observations.datasets[d].segments.size(), d != left_out);
  return mask;
}

TEST(FitToOthers, ArrivesWhereTheseAreAndSimulatesNothingElse) {
  const FittedToBoth fitted;
  const Problem& problem = *fitted.two.problem;
  const Comparison& comparison = fitted.comparison;
  const Fit& both = fitted.fit;
  ASSERT_TRUE(both.valid);

  for (int left_out = 0; left_out < 2; ++left_out) {
    const double truth = kStrengthOf[1 - left_out];
    ASSERT_GT(std::abs(both.p[kStrength] - truth), 0.1);  // the fit to both is of neither
    const SegmentMask mask = without(problem, left_out);
    const Whitening others = whitening_of(problem, comparison.noise, mask);
    (*fitted.two.simulated)[left_out] = 0;
    const auto p = fit_to_others(problem, comparison.whitening, others, mask, both);
    ASSERT_TRUE(p.has_value());
    EXPECT_NEAR((*p)[kStrength], truth, 2e-3);
    EXPECT_EQ((*fitted.two.simulated)[left_out], 1);
  }
}

TEST(FitToOthers, IsWhatAConditionThatIsLeftOutIsJudgedBy) {
  const FittedToBoth fitted;
  const Problem& problem = *fitted.two.problem;
  const Comparison& comparison = fitted.comparison;
  const Fit& both = fitted.fit;
  const Folds folds = folds_of(problem.observations, problem.settings);
  const JudgedFit judged = judge_fit(problem, comparison, folds, both, {});

  for (int left_out = 0; left_out < 2; ++left_out) {
    Vector p = problem.hypotheses.nominal();
    p[kStrength] = kStrengthOf[1 - left_out];
    const Fit of_the_other = evaluate_model(problem, comparison.whitening, p);
    const JudgedFit expected = judge_fit(problem, comparison, folds, of_the_other, {});
    ASSERT_TRUE(judged.folds[left_out] && expected.folds[left_out]);
    EXPECT_NEAR(judged.folds[left_out]->overall() / expected.folds[left_out]->overall(), 1.0, 0.01);
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
