// Tolerances that every model fits: evidence against an integral, an effect beside a tolerance of
// the same quantity, slopes that follow secants or are told along strong directions.

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>
#include <numbers>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/fit.h"
#include "diagnosis/selection/strong_directions.h"
#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

using test::toy_problem;
using test::toy_shape;

constexpr int kTolerance = 4;  // index of the parameter
constexpr double kTruth = 1.5;

void add_tolerance(Problem& problem) {
  problem.hypotheses.parameters.push_back(
      {"tolerance", "frequency", "deviations", 0.0, 1.0, {-2.0, 2.0}});
  problem.hypotheses.tolerances = {kTolerance};
}

/// Predictions of two channels over the toy's time by `value(channel, t, p)`.
template <class Value>
ForwardModel forward_of(Value&& value) {
  return [value](int, int, const Vector& p) {
    Prediction prediction;
    prediction.valid = true;
    prediction.step = 1e-3;
    prediction.values.resize(2, 531);
    for (int c = 0; c < 2; ++c)
      for (int i = 0; i < 531; ++i) prediction.values(c, i) = value(c, 1e-3 * i, p);
    return prediction;
  };
}

/// An oscillation whose frequency a tolerance moves: at the end of a run its slope at the files'
/// own value is off by as much as it says.
double oscillation(int channel, double t, const Vector& p) {
  const double first = p[0] * std::pow(t / 0.5, 3);
  return first + (channel == 0 ? t : 0.05 * std::sin((20.0 + 1.2 * p[kTolerance]) * t));
}

std::shared_ptr<Problem> oscillating_problem() {
  auto problem = toy_problem(Vector::Zero(4));
  add_tolerance(*problem);
  Vector truth = Vector::Zero(5);
  truth[kTolerance] = kTruth;
  std::mt19937 generator(3);
  std::normal_distribution<double> normal(0.0, 1e-3);
  for (Segment& segment : problem->observations.datasets[0].segments)
    for (int c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < segment.time[c].size(); ++i)
        segment.value[c][i] =
            oscillation(c, std::max(0.0, segment.time[c][i]), truth) + normal(generator);
  problem->forward = forward_of(oscillation);
  return problem;
}

Comparison comparison_at(const Problem& problem, const Vector& p) {
  return comparison_about(problem, with_random_effects(problem, estimate_noise(problem, p)));
}

/// log of prior times likelihood at the most probable tolerance, by the deviations of a fit. All
/// models share tolerances, so that under a plan they are not integrated over.
double most_probable(const Problem& problem, const Whitening& whitening, const Fit& fit) {
  const double step = 0.0005;
  double most = -kInfinity;
  for (double e = kTruth - 0.4; e <= kTruth + 0.4; e += step) {
    Vector p = fit.p;
    p[kTolerance] = e;
    const auto rows = rows_of(problem, whitening.alignments, predict_all(problem, p));
    const RandomEffects& random = whitening.random;
    const Weighed weighed =
        weigh(random, products_of(random, whitening.residual(rows)), fit.scales);
    most = std::max(most, -0.5 * (weighed.gram(0, 0) + weighed.log_det + e * e));
  }
  return most - std::log(std::erf(std::numbers::sqrt2));  // the prior ends at 2
}

TEST(FittedTolerances, GiveNoneTheDensityAtTheirMostProbable) {
  const auto problem = oscillating_problem();
  const Vector nominal = problem->hypotheses.nominal();
  Vector found = nominal;
  found[kTolerance] = kTruth;
  const Comparison comparison = comparison_at(*problem, found);
  const Whitening& whitening = comparison.whitening;

  const Fit none = fit_model(*problem, whitening, problem->hypotheses.freed_by({}), {nominal});
  ASSERT_TRUE(none.valid);
  EXPECT_NEAR(none.p[kTolerance], kTruth, 0.02);
  const Products alone = products_of(whitening.random, none.residual);
  const double cost =
      estimated_scales(whitening.random, alone, none.scales, 0, problem->settings.scale_spread)
          .log_cost;
  EXPECT_NEAR(none.log_evidence - cost, most_probable(*problem, whitening, none), 0.05);
}

TEST(FittedTolerances, ShareWithAnEffectOfTheSameQuantityAsPriorsSay) {
  // Data tell first + 0.05 e to a percent of either: what each is, priors of 0.1 and 0.05 decide.
  const double by_tolerance = 0.05, together = 0.12;
  auto problem = toy_problem(test::toy_truth(together, 0.0));
  add_tolerance(*problem);
  problem->forward = forward_of([&](int c, double t, const Vector& p) {
    Vector all = Vector::Zero(4);
    all[0] = p[0] + by_tolerance * p[kTolerance];
    return toy_shape(c, Vector::Constant(1, t), all)[0];
  });
  const Vector nominal = problem->hypotheses.nominal();
  const Comparison comparison = comparison_about(*problem, estimate_noise(*problem, nominal));

  const Fit fit =
      fit_model(*problem, comparison.whitening, problem->hypotheses.freed_by({0}), {nominal});
  ASSERT_TRUE(fit.valid);
  const double squares = 0.1 * 0.1 + by_tolerance * by_tolerance;
  const double deviation = 0.1 * by_tolerance / std::sqrt(squares);
  // A fit ends where its cost, some 500, falls by less than 1e-5 of itself: a tenth of a deviation.
  const double ended = 0.1 * deviation;
  EXPECT_NEAR(fit.p[0], together * 0.1 * 0.1 / squares, ended);
  EXPECT_NEAR(by_tolerance * fit.p[kTolerance], together * by_tolerance * by_tolerance / squares,
              ended);
  EXPECT_NEAR(0.1 * std::sqrt(fit.covariance(0, 0)), deviation, 1e-3);

  // The profile moves the tolerance along, to its end at two deviations below.
  const Bounds ci = interval95(*problem, comparison.whitening, fit, 0);
  EXPECT_NEAR(ci.upper, fit.p[0] + 1.96 * deviation, ended);
  EXPECT_LT(ci.lower, fit.p[0] - 0.03);

  // Their sum is what data tell, to a percent.
  problem->tolerance_part = [&](int c, const Vector&) {
    return Matrix(Matrix::Constant(1, 1, c == 0 ? by_tolerance : 0.0));
  };
  const Estimate sum = with_tolerances(*problem, comparison.whitening, fit, 0)[0];
  EXPECT_NEAR(sum.value, together, 0.02 * together);
  EXPECT_TRUE(sum.ci95.contains(together));
  EXPECT_LT(sum.ci95.upper - sum.ci95.lower, 0.1 * (ci.upper - ci.lower));
  EXPECT_EQ(theta_with_tolerances(*problem, fit, 0)[0], sum.value);
}

TEST(FittedTolerances, SlopesThatFollowSecantsKeepWhatIsLinear) {
  const auto problem = oscillating_problem();
  const Vector nominal = problem->hypotheses.nominal();
  const Comparison comparison = comparison_at(*problem, nominal);
  const std::vector<int> free = problem->hypotheses.freed_by({0});
  Residual residual(*problem, comparison.whitening, free, nominal);

  Vector u = residual.reduced(nominal), r;
  Matrix first, followed, renewed;
  ASSERT_TRUE(residual.value(u, r));
  first = *residual.slopes(u);
  u << 0.3, 0.4;
  ASSERT_TRUE(residual.value(u, r));
  followed = *residual.slopes(u);
  ASSERT_EQ(residual.secants().size(), 1U);
  renewed = *residual.renewed_slopes(u);
  EXPECT_TRUE(residual.secants().empty());

  // The effect is linear. Along the way the tolerance's secant is the mean of both ends' slopes.
  EXPECT_LT((followed.col(0) - first.col(0)).norm(), 1e-3 * first.col(0).norm());
  const Vector mean = 0.5 * (first.col(1) + renewed.col(1));
  EXPECT_LT((followed.col(1) - mean).norm(), 0.02 * mean.norm());
  EXPECT_GT((first.col(1) - mean).norm(), 0.05 * mean.norm());
}

TEST(FittedTolerances, StrongDirectionsLeaveNothingStrongBeside) {
  // Three columns: two alike, one nearly weak.
  Matrix slopes = Matrix::Zero(50, 3);
  slopes.col(0).setConstant(1.0);
  slopes.col(1).setConstant(2.0);
  slopes(0, 1) += 0.1;
  slopes(1, 2) = 0.5;
  const StrongDirections strong = strong_directions(slopes, 1.0, 0.0);
  ASSERT_EQ(strong.along.cols(), 1);
  EXPECT_NEAR(strong.sizes[0], (slopes * strong.along).norm(), 1e-12 * strong.sizes[0]);
  EXPECT_NEAR(strong.along.col(0).norm(), 1.0, 1e-12);
  const Matrix beside = slopes - slopes * strong.along * strong.along.transpose();
  EXPECT_LT(beside.jacobiSvd().singularValues()[0], 1.0);
  EXPECT_EQ(strong_directions(slopes, 0.4, 0.0).along.cols(), 2);
  EXPECT_EQ(strong_directions(slopes, 100.0, 0.0).along.cols(), 0);
  EXPECT_EQ(strong_directions(Matrix(50, 0), 1.0, 0.1).along.cols(), 0);
  // The first two cancel within a tenth of a deviation, and within more if each changes.
  const StrongDirections changed = strong_directions(slopes, 1.0, 0.2);
  ASSERT_EQ(changed.along.cols(), 2);
  EXPECT_GT(changed.sizes[0], 10.0 * (slopes * changed.along.col(0)).norm());
}

/// The oscillation moved by three tolerances that do the same where all are nominal; elsewhere two
/// do something of their own together.
std::shared_ptr<Problem> problem_of_alike(double own) {
  auto problem = oscillating_problem();
  for (const char* name : {"two", "three"}) {
    problem->hypotheses.tolerances.push_back(count_of(problem->hypotheses.parameters));
    problem->hypotheses.parameters.push_back(
        {"tolerance", name, "deviations", 0.0, 1.0, {-2.0, 2.0}});
  }
  problem->forward = forward_of([own](int channel, double t, const Vector& p) {
    Vector all = p.head(5);
    all[4] = p[4] + 0.5 * p[5] - 0.8 * p[6];
    return oscillation(channel, t, all) + (channel == 0 ? own * p[5] * p[6] * t * t : 0.0);
  });
  return problem;
}

/// Slopes by a residual that knows those at nominal, anew at another point, beside all differenced
/// there.
struct ToldElsewhere {
  Matrix first, renewed, by_rows, exact;
  long predictions = 0;
};
ToldElsewhere told_elsewhere(const Problem& problem) {
  const Vector nominal = problem.hypotheses.nominal();
  const Comparison comparison = comparison_at(problem, nominal);
  const std::vector<int> free = problem.hypotheses.freed_by({});
  Residual residual(problem, comparison.whitening, free, nominal);
  residual.keep_rows();
  ToldElsewhere told;
  Vector u = residual.reduced(nominal), r;
  EXPECT_TRUE(residual.value(u, r));
  told.first = *residual.slopes(u);

  u << 0.3, 0.2, -0.4;
  EXPECT_TRUE(residual.value(u, r));
  const long before = residual.predictions();
  told.renewed = *residual.renewed_slopes(u);
  told.predictions = residual.predictions() - before;
  told.by_rows = comparison.whitening.slopes(residual.nuisance_rows());
  Residual anew(problem, comparison.whitening, free, nominal);
  EXPECT_TRUE(anew.value(u, r));
  told.exact = *anew.slopes(u);
  return told;
}

TEST(FittedTolerances, AreToldAnewAlongTheDirectionsThatDataSee) {
  const auto problem = problem_of_alike(0.0);
  problem->settings.slope_changed = 0.0;
  const ToldElsewhere told = told_elsewhere(*problem);
  EXPECT_EQ(told.predictions, 1);  // one direction, not three tolerances
  EXPECT_GT((told.first - told.exact).norm(), 0.1 * told.exact.norm());
  EXPECT_LT((told.renewed - told.exact).norm(), 1e-2 * told.exact.norm());
  EXPECT_LT((told.by_rows - told.exact).norm(), 1e-2 * told.exact.norm());
}

TEST(FittedTolerances, AreToldAnewWhereStrongSlopesCancelledAndDoNoMore) {
  const auto problem = problem_of_alike(0.1);
  const ToldElsewhere told = told_elsewhere(*problem);
  problem->settings.slope_changed = 0.0;
  const ToldElsewhere as_told = told_elsewhere(*problem);
  EXPECT_GT((as_told.renewed - as_told.exact).norm(), 1.0);  // noise deviations
  EXPECT_LT((told.renewed - told.exact).norm(), 0.5 * (as_told.renewed - as_told.exact).norm());
  EXPECT_LT((told.renewed - told.exact).norm(), 1e-2 * told.exact.norm());
}

TEST(FittedTolerances, EffectsFollowASecantUntilTheyAreTold) {
  const auto problem = oscillating_problem();
  const Vector nominal = problem->hypotheses.nominal();
  const Comparison comparison = comparison_at(*problem, nominal);
  const std::vector<int> free = problem->hypotheses.freed_by({0});
  Residual residual(*problem, comparison.whitening, free, nominal);
  Vector u = residual.reduced(nominal), r0, r;
  ASSERT_TRUE(residual.value(u, r0));
  const Matrix first = *residual.slopes(u);

  const Vector step{{0.3, 0.4}};
  u += step;
  ASSERT_TRUE(residual.value(u, r));
  const long before = residual.predictions();
  ASSERT_TRUE(residual.follow(u));
  EXPECT_EQ(residual.predictions(), before);
  EXPECT_FALSE(residual.effects_told_at(u));
  EXPECT_LT((residual.told() * step - (r - r0)).norm(), 1e-9 * (r - r0).norm());

  const Matrix told = *residual.slopes(u);  // the effect's slope again
  EXPECT_EQ(residual.predictions(), before + 1);
  EXPECT_TRUE(residual.effects_told_at(u));
  EXPECT_LT((told.col(0) - first.col(0)).norm(), 1e-3 * first.col(0).norm());
}

/// The same oscillation moved by an unknown gain, and a tolerance that is linear.
std::shared_ptr<Problem> problem_with_gain(const Vector& truth) {
  auto problem = toy_problem(Vector::Zero(4));
  problem->hypotheses.parameters.push_back({"nuisance", "log_kp", "-", 0.0, 1.0, {-4.0, 4.0}});
  problem->hypotheses.parameters.push_back(
      {"tolerance", "slope", "deviations", 0.0, 1.0, {-2.0, 2.0}});
  problem->hypotheses.gains = {4};
  problem->hypotheses.tolerances = {5};
  const auto value = [](int channel, double t, const Vector& p) {
    return oscillation(channel, t, p) + 0.03 * p[5] * t * t;
  };
  for (Segment& segment : problem->observations.datasets[0].segments)
    for (int c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < segment.time[c].size(); ++i)
        segment.value[c][i] = value(c, segment.time[c][i], truth);
  problem->forward = forward_of(value);
  return problem;
}

TEST(FittedTolerances, GainsFollowSecantsWhereTolerancesGoByTheirSlopes) {
  Vector truth = Vector::Zero(6);
  truth[0] = 0.2;
  truth[4] = 1.5;
  truth[5] = 0.5;
  const auto problem = problem_with_gain(truth);
  const Vector nominal = problem->hypotheses.nominal();
  const Comparison comparison = comparison_at(*problem, nominal);
  const std::vector<int> free = problem->hypotheses.freed_by({0});
  const LinearNuisances linear = linear_nuisances(*problem, comparison.whitening, nominal);
  ASSERT_EQ(linear.slopes.cols(), 2);

  Residual residual(*problem, comparison.whitening, free, nominal, linear);
  ASSERT_EQ(residual.followed(), 1);
  Vector u = residual.reduced(nominal), r;
  Matrix first, followed, renewed;
  ASSERT_TRUE(residual.value(u, r));
  first = *residual.slopes(u);
  EXPECT_EQ(residual.predictions(), 2);  // the point and the effect
  u << 0.3, 0.4, 0.5;
  ASSERT_TRUE(residual.value(u, r));
  followed = *residual.slopes(u);
  EXPECT_EQ(residual.predictions(), 4);
  renewed = *residual.renewed_slopes(u);
  EXPECT_EQ(residual.predictions(), 6);  // the effect and the gain, not the tolerance

  const Vector mean = 0.5 * (first.col(1) + renewed.col(1));
  EXPECT_LT((followed.col(1) - mean).norm(), 0.02 * mean.norm());
  EXPECT_EQ(followed.col(2), linear.slopes.col(1));

  // A fit that follows ends where one that differences all does: either within what counts as
  // settled of the optimum, whose cost rises by half the square of a parameter's deviations.
  const double settled = problem->settings.scales_settled;
  FitOptions by_slopes;
  by_slopes.by_slopes = &linear;
  const Fit fast = fit_model(*problem, comparison.whitening, free, {nominal}, by_slopes);
  const Fit exact = fit_model(*problem, comparison.whitening, free, {nominal});
  ASSERT_TRUE(fast.valid && exact.valid);
  for (const int i : free) {
    const int k = index_of(exact.free, i);
    const double deviation =
        problem->hypotheses.parameters[i].scale * std::sqrt(exact.covariance(k, k));
    EXPECT_NEAR(fast.p[i], exact.p[i], 2.0 * std::sqrt(2.0 * settled) * deviation) << i;
  }
  EXPECT_NEAR(fast.log_evidence, exact.log_evidence, 2.0 * settled);
}

}  // namespace
}  // namespace jaculus::diagnosis
