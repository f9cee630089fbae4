// What the datasets of a fold leave open of tolerances: a healthy robot's prediction of a condition
// that it was never seen in is as uncertain as these.

#include <gtest/gtest.h>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/toy.h"
#include "diagnosis/validation/held_out.h"

namespace jaculus::diagnosis {
namespace {

using test::toy_problem;
using test::toy_shape;

constexpr int kStiffness = 4;   // index of the parameter
constexpr double kMoved = 0.1;  // by one deviation of it at the end of the second dataset

double value_of(int dataset, int channel, double t, const Vector& p) {
  const Vector time = Vector::Constant(1, t);
  const double s = std::max(0.0, t) / 0.5;
  return toy_shape(channel, time, p.head(4))[0] + (dataset == 1 ? kMoved * p[kStiffness] * s : 0.0);
}

/// Two conditions of one robot, of which the second alone shows its tolerance.
std::shared_ptr<Problem> two_conditions(double deviations) {
  auto problem = toy_problem(Vector::Zero(4));
  problem->hypotheses.parameters.push_back(
      {"tolerance", "stiffness", "deviations", 0.0, 1.0, {-2.0, 2.0}});
  problem->hypotheses.tolerances = {kStiffness};
  test::ToyData other;
  other.seed = 2;
  problem->observations.datasets.push_back(
      toy_problem(Vector::Zero(4), other)->observations.datasets[0]);
  for (Segment& segment : problem->observations.datasets[1].segments)
    for (int c = 0; c < 2; ++c)
      segment.value[c].array() += kMoved * deviations * segment.time[c].array().max(0.0) / 0.5;

  problem->forward = [](int dataset, int, const Vector& p) {
    Prediction prediction;
    prediction.valid = true;
    prediction.step = 1e-3;
    prediction.values.resize(2, 531);
    for (int c = 0; c < 2; ++c)
      for (int i = 0; i < 531; ++i) prediction.values(c, i) = value_of(dataset, c, 1e-3 * i, p);
    return prediction;
  };
  return problem;
}

struct Judged {
  JudgedFit open, closed;
};

Judged judged_without_effects(const Problem& problem) {
  const Vector nominal = problem.hypotheses.nominal();
  const Comparison comparison =
      comparison_about(problem, with_random_effects(problem, estimate_noise(problem, nominal)));
  const Fit none =
      fit_model(problem, comparison.whitening, problem.hypotheses.freed_by({}), {nominal});
  const Folds folds = folds_of(problem.observations, problem.settings);
  const OpenRows open = open_rows(problem, comparison, folds, none);
  return {judge_fit(problem, comparison, folds, none, open),
          judge_fit(problem, comparison, folds, none, {})};
}

TEST(OpenTolerances, AreNoGapOfAConditionThatNoneOfTheOthersTells) {
  const Judged judged = judged_without_effects(*two_conditions(1.0));
  // A deviation is what the error is expected to be; as sensors alone have it, it is many floors.
  EXPECT_NEAR(judged.open.folds[1]->overall(), 1.0, 0.1);
  EXPECT_GT(judged.closed.folds[1]->overall(), 20.0);
  EXPECT_GT(judged.open.folds[1]->log_density, judged.closed.folds[1]->log_density + 1000.0);
}

TEST(OpenTolerances, LeaveAsItIsWhatTheOthersTell) {
  const Judged judged = judged_without_effects(*two_conditions(1.0));
  // The first condition doesn't move with the tolerance.
  EXPECT_NEAR(judged.open.folds[0]->overall(), judged.closed.folds[0]->overall(), 1e-6);
}

TEST(OpenTolerances, AreLeftOutWhereTrialsOfOneConditionJudgeEachOther) {
  const auto problem = toy_problem(Vector::Zero(4));
  const Vector nominal = problem->hypotheses.nominal();
  const Comparison comparison = comparison_about(*problem, estimate_noise(*problem, nominal));
  const Fit none = evaluate_model(*problem, comparison.whitening, nominal);
  const Folds folds = folds_of(problem->observations, problem->settings);
  EXPECT_TRUE(open_rows(*problem, comparison, folds, none).empty());
}

}  // namespace
}  // namespace jaculus::diagnosis
