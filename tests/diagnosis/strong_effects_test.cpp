// Effects beyond the reach of slopes: screening's line search, jumps dated by the data.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "diagnosis/noise/whitening.h"
#include "diagnosis/selection/fit.h"
#include "diagnosis/selection/screen.h"
#include "diagnosis/selection/search.h"
#include "diagnosis/toy.h"

namespace jaculus::test {
namespace {

using Shape = std::function<double(int channel, double time, const Vector& p)>;

/// The toy with another shape: data made by it at `truth`, predictions likewise, with impacts at
/// `impact(p)` if given.
std::shared_ptr<diagnosis::Problem> shaped(
    const Shape& shape, const Vector& truth,
    const std::function<double(const Vector&)>& impact = {}) {
  auto problem = toy_problem(truth);
  std::mt19937 generator(3);
  std::normal_distribution<double> normal(0.0, 1e-3);
  for (diagnosis::Segment& segment : problem->observations.datasets[0].segments)
    for (std::size_t c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < segment.time[c].size(); ++i)
        segment.value[c][i] = shape(static_cast<int>(c), std::max(0.0, segment.time[c][i]), truth) +
                              normal(generator);
  problem->forward = [=](int, int, const Vector& p) {
    diagnosis::Prediction prediction;
    prediction.valid = true;
    prediction.step = 1e-3;
    prediction.values.resize(2, 531);
    for (int c = 0; c < 2; ++c)
      for (int i = 0; i < 531; ++i) prediction.values(c, i) = shape(c, 1e-3 * i, p);
    if (impact) prediction.impacts = {impact(p)};
    return prediction;
  };
  return problem;
}

TEST(LineSearch, FindsAStrengthWhoseValleyIsNarrow) {
  // The candidate turns a phase, so that away from the truth a slope leads into the wrong valley.
  const auto problem =
      shaped([](int channel, double t,
                const Vector& p) { return channel == 0 ? t : 0.05 * std::sin(120.0 * p[1] * t); },
             toy_truth(0.0, 0.43));
  const diagnosis::NoiseModel about = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  const diagnosis::Whitening space = diagnosis::whitening_of(*problem, about);
  const diagnosis::Fit none = diagnosis::evaluate_model(*problem, space, Vector::Zero(4));
  const diagnosis::Probe with = diagnosis::screen(*problem, space, none,
                                                  diagnosis::Screening::line_search)[1],
                         without = diagnosis::screen(*problem, space, none)[1];
  ASSERT_TRUE(with.valid);
  EXPECT_NEAR(0.1 * with.step, 0.43, 0.01);  // rungs beside the truth are at 0.4 and 0.8
  EXPECT_GT(with.score, without.score);
  const diagnosis::Fit climbed =
      diagnosis::fit_model(*problem, space, {1}, diagnosis::fit_starts(*problem, none.p, 1, with));
  const diagnosis::Fit walked = diagnosis::fit_model(
      *problem, space, {1}, diagnosis::fit_starts(*problem, none.p, 1, without));
  EXPECT_NEAR(climbed.p[1], 0.43, 1e-3);
  EXPECT_GT(std::abs(walked.p[1] - 0.43), 0.02);
}

TEST(LineSearch, FindsTheValleyJustPastAThreshold) {
  // Nothing up to 0.3, then soon too much: at the probing step and at most rungs the candidate does
  // nothing, or harm.
  const auto problem = shaped(
      [](int channel, double t, const Vector& p) {
        return channel == 0 ? t : 40.0 * std::max(0.0, p[1] - 0.3) * std::sin(9.0 * t);
      },
      toy_truth(0.0, 0.31));
  const diagnosis::NoiseModel about = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  const diagnosis::Whitening space = diagnosis::whitening_of(*problem, about);
  const diagnosis::Fit none = diagnosis::evaluate_model(*problem, space, Vector::Zero(4));
  EXPECT_FALSE(diagnosis::screen(*problem, space, none, diagnosis::Screening::steps)[1].valid);
  const diagnosis::Probe probe =
      diagnosis::screen(*problem, space, none, diagnosis::Screening::line_search)[1];
  ASSERT_TRUE(probe.valid);
  EXPECT_NEAR(0.1 * probe.step, 0.31, 0.01);
  EXPECT_NEAR(
      diagnosis::fit_model(*problem, space, {1}, diagnosis::fit_starts(*problem, none.p, 1, probe))
          .p[1],
      0.31, 1e-3);
}

/// Screened as the first search does, about the model without effects at `nominal`.
diagnosis::Probe probe_of_second(const diagnosis::Problem& problem, const Vector& nominal) {
  const diagnosis::Whitening space =
      diagnosis::whitening_of(problem, diagnosis::estimate_noise(problem, nominal));
  const diagnosis::Fit none = diagnosis::evaluate_model(problem, space, nominal);
  return diagnosis::probe_candidate(problem, space, none,
                                    diagnosis::standing_of(problem, space, none), 1,
                                    diagnosis::Screening::line_search);
}

/// Of one parameter, what it changes by `strength`.
Shape bent(std::function<double(double p)> strength) {
  return [=](int channel, double t, const Vector& p) {
    return channel == 0 ? t : strength(p[1]) * std::sin(9.0 * t);
  };
}

TEST(Screening, GoesToTheEstimateInOneStepWhereTheSlopeHolds) {
  // Three probing steps of 0.1: small, whole, and one to there.
  const auto far = shaped(bent([](double p) { return p; }), toy_truth(0.0, 0.3));
  const diagnosis::Probe probe = probe_of_second(*far, Vector::Zero(4));
  EXPECT_NEAR(probe.estimate[0], 3.0, 0.1);
  EXPECT_EQ(probe.predictions, 3);
  EXPECT_TRUE(std::isnan(probe.step));

  const auto near = shaped(bent([](double p) { return p; }), toy_truth(0.0, 0.05));
  EXPECT_EQ(probe_of_second(*near, Vector::Zero(4)).predictions, 2);
}

TEST(Screening, SearchesALineWhereTheSlopeBendsOrLeavesItsSide) {
  const auto steeper = [](double p) { return p < 0.15 ? p : 0.15 + 3.0 * (p - 0.15); };
  const auto beyond = shaped(bent(steeper), toy_truth(0.0, 0.3));
  EXPECT_NEAR(0.1 * probe_of_second(*beyond, Vector::Zero(4)).step, 0.3, 0.02);

  // Against the side that was probed nothing happens, though the slope there says it would.
  const auto one_way = shaped(bent([](double p) { return std::abs(p); }), toy_truth(0.0, 0.0));
  diagnosis::Problem problem = *one_way;
  for (diagnosis::Segment& segment : problem.observations.datasets[0].segments)
    for (Eigen::Index i = 0; i < segment.time[1].size(); ++i)
      segment.value[1][i] -= 0.05 * std::sin(9.0 * std::max(0.0, segment.time[1][i]));
  EXPECT_GT(probe_of_second(problem, Vector::Zero(4)).predictions, 10);

  // No slope is trusted farther than a line is searched.
  const auto farther = shaped(bent([](double p) { return p; }), toy_truth(0.0, 0.95));
  EXPECT_GT(probe_of_second(*farther, Vector::Zero(4)).predictions, 10);
}

TEST(Screening, StopsAtABound) {
  // 1 - 0.9 is less than 0.1 in doubles; a step that turned back there would say nothing of it.
  std::mutex guard;
  std::vector<double> asked;
  const auto shape = [&](int channel, double t, const Vector& p) {
    if (channel == 1 && t == 0.0) {
      const std::lock_guard<std::mutex> lock(guard);
      asked.push_back(p[1]);
    }
    return channel == 0 ? t : (p[1] - 1.0) * std::sin(9.0 * t);
  };
  Vector truth = toy_truth(0.0, 0.05), nominal = toy_truth(0.0, 1.0);
  diagnosis::Problem problem = *shaped(shape, truth);
  problem.hypotheses.parameters[1].nominal = 1.0;
  problem.hypotheses.parameters[1].scale = 0.4;
  problem.hypotheses.parameters[1].bounds = {0.1, 2.0};
  const diagnosis::Probe probe = probe_of_second(problem, nominal);
  EXPECT_EQ(probe.predictions, 3);
  EXPECT_NEAR(1.0 + 0.4 * probe.estimate[0], 0.1, 1e-12);
  EXPECT_NEAR(asked.back(), 0.1, 1e-15);
  EXPECT_LT(*std::max_element(asked.begin(), asked.end()), 1.5);
}

TEST(Search, FitsAgainWhatLedThoughScreeningMissesIt) {
  // Without steps between its rungs the line search passes the valley by.
  const auto narrow =
      shaped([](int channel, double t,
                const Vector& p) { return channel == 0 ? t : 0.05 * std::sin(120.0 * p[1] * t); },
             toy_truth(0.0, 0.43));
  diagnosis::Problem problem = *narrow;
  problem.settings.line_search_refinements = 0;
  problem.settings.tolerances_granted = 0;
  const diagnosis::Comparison comparison = diagnosis::comparison_about(
      problem,
      diagnosis::with_random_effects(problem, diagnosis::estimate_noise(problem, Vector::Zero(4))));
  const diagnosis::SearchOptions once{.largest = 1};
  diagnosis::SearchResult earlier = diagnosis::search_models(problem, comparison, once);
  const auto phase = [](const diagnosis::SearchResult& found) {
    for (const diagnosis::ModelFit& model : found.models)
      if (model.candidates == std::vector<int>{1} && model.fit.valid) return model.fit.p[1];
    return kNaN;
  };
  ASSERT_FALSE(std::abs(phase(earlier) - 0.43) < 0.02) << "it has to be missed first";

  diagnosis::ModelFit led;
  led.candidates = {1};
  led.fit = diagnosis::fit_model(problem, comparison.whitening, {1}, {toy_truth(0.0, 0.425)});
  std::erase_if(earlier.models, [](const auto& model) { return !model.candidates.empty(); });
  earlier.models.push_back(led);
  const diagnosis::SearchOptions again{.largest = 1, .earlier = &earlier};
  EXPECT_NEAR(phase(diagnosis::search_models(problem, comparison, again)), 0.43, 1e-3);
}

TEST(Fit, ReachesItsOptimumFromGivenSlopesThatAreWrong) {
  const auto problem = toy_problem(toy_truth(0.3, 0.43));
  const diagnosis::Comparison comparison = diagnosis::comparison_about(
      *problem, diagnosis::with_random_effects(
                    *problem, diagnosis::estimate_noise(*problem, Vector::Zero(4))));
  const auto fitted = [&](const Matrix& slopes) {
    diagnosis::FitOptions options;
    options.effect_slopes = slopes;
    return diagnosis::fit_model(*problem, comparison.whitening, {0, 1}, {Vector::Zero(4)}, options);
  };
  const diagnosis::Fit plain = fitted({});
  ASSERT_TRUE(plain.valid);
  for (const double share : {1.0, -1.0, 0.2}) {
    const diagnosis::Fit given = fitted(share * plain.jacobian);
    ASSERT_TRUE(given.valid) << share;
    EXPECT_NEAR(given.log_evidence, plain.log_evidence, 0.1) << share;
    EXPECT_NEAR(given.p[1], plain.p[1], 1e-3) << share;
  }
}

TEST(Jump, CountsForLittleBetweenItsPredictedAndItsMeasuredTime) {
  const auto at = [](const Vector& p) { return 0.25 + 0.02 * p[1]; };
  const auto problem =
      shaped([at](int channel, double t,
                  const Vector& p) { return channel == 0 ? t : (t > at(p) ? 1.0 : 0.0); },
             toy_truth(0.0, 0.75), at);
  const diagnosis::NoiseModel about = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  const diagnosis::Whitening space = diagnosis::whitening_of(*problem, about);
  const diagnosis::DatasetWhitening& rows = space.datasets[0];
  int first = 0;
  for (const diagnosis::RowSpan& span : rows.spans) {
    const Vector& time = problem->observations.datasets[0].segments[span.segment].time[0];
    for (int i = 0; i < span.count && span.channel == 1; ++i) {
      const double t = time[i];
      if (t > 0.25 && t < 0.265) {
        EXPECT_GT(rows.sigma[first + i], 0.4) << t;
      } else if (t < 0.24 || t > 0.275) {
        EXPECT_LT(rows.sigma[first + i], 0.01) << t;
      }
    }
    first += span.count;
  }
  // Both the nominal time and the true one are thus reached without a wall between them.
  Vector truth = toy_truth(0.0, 0.75);
  for (const double share : {0.0, 0.3, 0.6, 1.0})
    EXPECT_LT(diagnosis::evaluate_model(*problem, space, share * truth).chi2, 3.0 * space.rows)
        << share;
}

TEST(Jump, MayComeTheLaterTheMoreReboundsCameBefore) {
  // Rebounds at 0.1 and 0.3 s; both channels rise at the same rate throughout.
  const auto problem = shaped(
      [](int channel, double t, const Vector&) { return (channel + 1) * t; }, Vector::Zero(4));
  const diagnosis::ForwardModel bare = problem->forward;
  problem->forward = [bare](int c, int r, const Vector& p) {
    diagnosis::Prediction prediction = bare(c, r, p);
    prediction.impacts = {0.1, 0.3};
    return prediction;
  };
  const diagnosis::NoiseModel about = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  const diagnosis::Whitening space = diagnosis::whitening_of(*problem, about);
  const diagnosis::ObservedDataset& dataset = problem->observations.datasets[0];
  const diagnosis::RowSpan span = space.datasets[0].spans[0];
  const Vector& time = dataset.segments[0].time[0];
  double before = 0.0, between = 0.0, after = 0.0;
  for (int i = 0; i < span.count; ++i) {
    const double sigma = space.datasets[0].sigma[i];
    if (time[i] < 0.08) before = std::max(before, sigma);
    if (time[i] > 0.12 && time[i] < 0.28) between = std::max(between, sigma);
    if (time[i] > 0.32) after = std::max(after, sigma);
  }
  EXPECT_LT(between, 1.1 * before);
  EXPECT_GT(after, 3.0 * between);  // 2 % of the 0.2 s between them, at 1/s
}

TEST(Fit, EvidenceAtABoundCountsWhatLiesWithinIt) {
  // The truth is far beyond the bound. No average over what is allowed exceeds the likelihood of
  // the best of it.
  const auto problem = toy_problem(toy_truth(0.0, 0.8));
  diagnosis::FreeParameter& own = problem->hypotheses.parameters[1];
  own.bounds = {-0.2, 0.25};
  const diagnosis::NoiseModel about = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  const diagnosis::Whitening space = diagnosis::whitening_of(*problem, about);
  const diagnosis::Fit walled = diagnosis::fit_model(*problem, space, {1}, {Vector::Zero(4)});
  ASSERT_TRUE(walled.valid);
  EXPECT_NEAR(walled.p[1], 0.25, 1e-6);
  EXPECT_LT(walled.log_evidence, -0.5 * walled.chi2);
  // With room on both sides it is what it was without bounds, and the share of the prior that they
  // leave.
  own.bounds = {-1.0, 1.0};
  const diagnosis::Fit open = diagnosis::fit_model(*problem, space, {1}, {Vector::Zero(4)});
  own.bounds = {-kInfinity, kInfinity};
  EXPECT_NEAR(open.log_evidence,
              diagnosis::fit_model(*problem, space, {1}, {Vector::Zero(4)}).log_evidence, 1e-3);
}

TEST(Space, HeldRowsTellNothingBeforeALateCommandArrives) {
  const auto problem = toy_problem(Vector::Zero(4));
  problem->observations.datasets[0].channels[1].zero_order_hold = true;
  const diagnosis::ForwardModel bare = problem->forward;
  problem->forward = [bare](int c, int r, const Vector& p) {
    diagnosis::Prediction prediction = bare(c, r, p);
    prediction.late = {0.02, 0.02};
    return prediction;
  };
  const diagnosis::NoiseModel about = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  const diagnosis::Whitening space = diagnosis::whitening_of(*problem, about);
  const diagnosis::ObservedDataset& dataset = problem->observations.datasets[0];
  int first = 0;
  for (const diagnosis::RowSpan& span : space.datasets[0].spans) {
    const auto& segment = dataset.segments[span.segment];
    const Vector& time = segment.time[span.channel];
    const double floor = about.datasets[0].channels[span.channel].noise_floor;
    for (int i = 0; i < span.count; ++i) {
      const double t = time[i] - about.alignments[0].segments[span.segment].shift[0];
      const bool told = span.channel == 0 || t > 0.02 + problem->settings.command_settles;
      EXPECT_EQ(space.datasets[0].sigma[first + i] < 10.0 * floor, told)
          << span.channel << " " << t;
    }
    first += span.count;
  }
}

TEST(Fit, LooksAroundForALowerValley) {
  // A wave over a bowl: its valleys are 0.05 apart, the true one at 0.43.
  const auto problem =
      shaped([](int channel, double t,
                const Vector& p) { return channel == 0 ? t : 0.05 * std::sin(240.0 * p[1] * t); },
             toy_truth(0.0, 0.43));
  const diagnosis::NoiseModel about = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  const diagnosis::Whitening space = diagnosis::whitening_of(*problem, about);
  Vector start = Vector::Zero(4);
  for (start[1] = 0.34; start[1] < 0.41; start[1] += 0.005) {
    const diagnosis::Fit beside = diagnosis::fit_model(*problem, space, {1}, {start});
    if (!beside.valid || beside.p[1] < 0.36 || beside.p[1] > 0.4) continue;
    EXPECT_NEAR(diagnosis::fit_around(*problem, space, beside).p[1], 0.43, 1e-3);
    return;
  }
  FAIL() << "no valley beside the true one";
}

}  // namespace
}  // namespace jaculus::test
