// Effects beyond the reach of slopes: screening's ladder, jumps dated by the data, probabilities as stated.

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "diagnosis/calibration.h"
#include "diagnosis/toy.h"
#include "jaculus/diagnosis/evidence_space.h"
#include "jaculus/diagnosis/fit.h"
#include "jaculus/diagnosis/screen.h"

namespace jaculus::test {
namespace {

using Shape = std::function<double(int channel, double time, const Vector& p)>;

/// The toy with another shape: data made by it at `truth`, predictions likewise, with impacts at `impact(p)` if given.
std::shared_ptr<DiagnosisProblem> shaped(const Shape& shape, const Vector& truth,
                                         const std::function<double(const Vector&)>& impact = {}) {
  auto problem = toy_problem(truth);
  std::mt19937 generator(3);
  std::normal_distribution<double> normal(0.0, 1e-3);
  for (Run& run : problem->observations.conditions[0].runs)
    for (std::size_t c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < run.time[c].size(); ++i)
        run.value[c][i] = shape(static_cast<int>(c), std::max(0.0, run.time[c][i]), truth) + normal(generator);
  problem->forward = [=](int, int, const Vector& p) {
    Prediction prediction;
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

TEST(Ladder, FindsAStrengthWhoseValleyIsNarrow) {
  // The candidate turns a phase, so that away from the truth a slope leads into the wrong valley.
  const auto problem = shaped(
      [](int channel, double t, const Vector& p) { return channel == 0 ? t : 0.05 * std::sin(120.0 * p[1] * t); },
      toy_truth(0.0, 0.43));
  const Linearisation about = linearise(*problem, Vector::Zero(4));
  const EvidenceSpace space = evidence_space(*problem, about);
  const Fit none = evaluate_model(*problem, space, Vector::Zero(4));
  const Probe with = screen(*problem, space, none, Screening::ladder)[1], without = screen(*problem, space, none)[1];
  ASSERT_TRUE(with.valid);
  EXPECT_NEAR(0.1 * with.rung, 0.4, 0.11);  // the rung beside the truth
  EXPECT_GT(with.score, without.score);
  const Fit climbed = fit_model(*problem, space, {1}, fit_starts(*problem, none.p, 1, with));
  const Fit walked = fit_model(*problem, space, {1}, fit_starts(*problem, none.p, 1, without));
  EXPECT_NEAR(climbed.p[1], 0.43, 1e-3);
  EXPECT_GT(std::abs(walked.p[1] - 0.43), 0.02);
}

TEST(Ladder, FindsTheValleyJustPastAThreshold) {
  // Nothing up to 0.3, then soon too much: at the probing step and at most rungs the candidate does nothing, or harm.
  const auto problem =
      shaped([](int channel, double t,
                const Vector& p) { return channel == 0 ? t : 40.0 * std::max(0.0, p[1] - 0.3) * std::sin(9.0 * t); },
             toy_truth(0.0, 0.31));
  const Linearisation about = linearise(*problem, Vector::Zero(4));
  const EvidenceSpace space = evidence_space(*problem, about);
  const Fit none = evaluate_model(*problem, space, Vector::Zero(4));
  EXPECT_FALSE(screen(*problem, space, none, Screening::steps)[1].valid);
  const Probe probe = screen(*problem, space, none, Screening::ladder)[1];
  ASSERT_TRUE(probe.valid);
  EXPECT_NEAR(0.1 * probe.rung, 0.31, 0.01);
  EXPECT_NEAR(fit_model(*problem, space, {1}, fit_starts(*problem, none.p, 1, probe)).p[1], 0.31, 1e-3);
}

TEST(Jump, CountsForLittleBetweenItsPredictedAndItsMeasuredTime) {
  const auto at = [](const Vector& p) { return 0.25 + 0.02 * p[1]; };
  const auto problem =
      shaped([at](int channel, double t, const Vector& p) { return channel == 0 ? t : (t > at(p) ? 1.0 : 0.0); },
             toy_truth(0.0, 0.75), at);
  const Linearisation about = linearise(*problem, Vector::Zero(4));
  const EvidenceSpace space = evidence_space(*problem, about);
  const ConditionSpace& rows = space.conditions[0];
  int first = 0;
  for (const RowSpan& span : rows.spans) {
    const Vector& time = problem->observations.conditions[0].runs[static_cast<std::size_t>(span.run)].time[0];
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
    EXPECT_LT(evaluate_model(*problem, space, share * truth).chi2, 3.0 * space.rows) << share;
}

TEST(Jump, MayComeTheLaterTheMoreReboundsCameBefore) {
  // Rebounds at 0.1 and 0.3 s; both channels rise at the same rate throughout.
  const auto problem = shaped([](int channel, double t, const Vector&) { return (channel + 1) * t; }, Vector::Zero(4));
  const ForwardModel bare = problem->forward;
  problem->forward = [bare](int c, int r, const Vector& p) {
    Prediction prediction = bare(c, r, p);
    prediction.impacts = {0.1, 0.3};
    return prediction;
  };
  const Linearisation about = linearise(*problem, Vector::Zero(4));
  const EvidenceSpace space = evidence_space(*problem, about);
  const Condition& condition = problem->observations.conditions[0];
  const RowSpan span = space.conditions[0].spans[0];
  const Vector& time = condition.runs[0].time[0];
  double before = 0.0, between = 0.0, after = 0.0;
  for (int i = 0; i < span.count; ++i) {
    const double sigma = space.conditions[0].sigma[i];
    if (time[i] < 0.08) before = std::max(before, sigma);
    if (time[i] > 0.12 && time[i] < 0.28) between = std::max(between, sigma);
    if (time[i] > 0.32) after = std::max(after, sigma);
  }
  EXPECT_LT(between, 1.1 * before);
  EXPECT_GT(after, 3.0 * between);  // 2 % of the 0.2 s between them, at 1/s
}

TEST(Fit, EvidenceAtABoundCountsWhatLiesWithinIt) {
  // The truth is far beyond the bound. No average over what is allowed exceeds the likelihood of the best of it.
  const auto problem = toy_problem(toy_truth(0.0, 0.8));
  FreeParameter& own = problem->hypotheses.parameters[1];
  own.bounds = {-0.2, 0.25};
  const Linearisation about = linearise(*problem, Vector::Zero(4));
  const EvidenceSpace space = evidence_space(*problem, about);
  const Fit walled = fit_model(*problem, space, {1}, {Vector::Zero(4)});
  ASSERT_TRUE(walled.valid);
  EXPECT_NEAR(walled.p[1], 0.25, 1e-6);
  EXPECT_LT(walled.log_evidence, -0.5 * walled.chi2);
  // With room on both sides it is what it was without bounds, and the share of the prior that they leave.
  own.bounds = {-1.0, 1.0};
  const Fit open = fit_model(*problem, space, {1}, {Vector::Zero(4)});
  own.bounds = {-kInfinity, kInfinity};
  EXPECT_NEAR(open.log_evidence, fit_model(*problem, space, {1}, {Vector::Zero(4)}).log_evidence, 1e-3);
}

TEST(Space, HeldRowsTellNothingBeforeALateCommandArrives) {
  const auto problem = toy_problem(Vector::Zero(4));
  problem->observations.conditions[0].channels[1].held = true;
  const ForwardModel bare = problem->forward;
  problem->forward = [bare](int c, int r, const Vector& p) {
    Prediction prediction = bare(c, r, p);
    prediction.late = {0.02, 0.02};
    return prediction;
  };
  const Linearisation about = linearise(*problem, Vector::Zero(4));
  const EvidenceSpace space = evidence_space(*problem, about);
  const Condition& condition = problem->observations.conditions[0];
  int first = 0;
  for (const RowSpan& span : space.conditions[0].spans) {
    const auto& run = condition.runs[static_cast<std::size_t>(span.run)];
    const Vector& time = run.time[static_cast<std::size_t>(span.channel)];
    const double floor = condition.channels[static_cast<std::size_t>(span.channel)].noise_floor;
    for (int i = 0; i < span.count; ++i) {
      const double t = time[i] - run.shift[0];
      const bool told = span.channel == 0 || t > 0.02 + kCommanded;
      EXPECT_EQ(space.conditions[0].sigma[first + i] < 10.0 * floor, told) << span.channel << " " << t;
    }
    first += span.count;
  }
}

TEST(Fit, LooksAroundForALowerValley) {
  // A wave over a bowl: its valleys are 0.05 apart, the true one at 0.43.
  const auto problem = shaped(
      [](int channel, double t, const Vector& p) { return channel == 0 ? t : 0.05 * std::sin(240.0 * p[1] * t); },
      toy_truth(0.0, 0.43));
  const Linearisation about = linearise(*problem, Vector::Zero(4));
  const EvidenceSpace space = evidence_space(*problem, about);
  Vector start = Vector::Zero(4);
  for (start[1] = 0.34; start[1] < 0.41; start[1] += 0.005) {
    const Fit beside = fit_model(*problem, space, {1}, {start});
    if (!beside.valid || beside.p[1] < 0.36 || beside.p[1] > 0.4) continue;
    EXPECT_NEAR(fit_around(*problem, space, beside).p[1], 0.43, 1e-3);
    return;
  }
  FAIL() << "no valley beside the true one";
}

Diagnosis diagnosis(const std::string& verdict, const std::vector<std::string>& effects) {
  Diagnosis out;
  out.verdict = verdict;
  for (const std::string& name : effects) out.effects.push_back({name, "", 1.0, {}, {}});
  out.gap.valid = true;
  out.gap.before = 4.0;
  out.gap.after = 1.0;
  out.ranking = {{"a + b", 50.0, 1.0, 0.9, {"a", "b"}},
                 {"a", 45.0, 1.0, 0.1, {"a"}},
                 {"c", 3.0, 2.0, 0.0, {"c"}},
                 {"unexplained", 40.0, kNaN, 0.0, {}},
                 {"none", 0.0, 4.0, 0.0, {}}};
  return out;
}

double probability(const Diagnosis& d, const std::string& name) {
  for (const Ranked& row : d.ranking)
    if (row.effect == name) return row.probability;
  return kNaN;
}

TEST(Calibration, GivesEveryVerdictItsShareAndSumsToOne) {
  for (const auto& [verdict, effects] : {std::pair<std::string, std::vector<std::string>>{"effect", {"a"}},
                                         {"several", {"a", "b"}},
                                         {"none", {}},
                                         {"unexplained", {}}}) {
    SCOPED_TRACE(verdict);
    Diagnosis d = diagnosis(verdict, effects);
    calibrate(d);
    double sum = 0.0;
    for (const Ranked& row : d.ranking) sum += row.probability;
    EXPECT_NEAR(sum, 1.0, 1e-12);
    for (std::size_t i = 1; i < d.ranking.size(); ++i)
      EXPECT_GE(d.ranking[i - 1].probability, d.ranking[i].probability);
    for (const Ranked& row : d.ranking) EXPECT_GT(row.probability, 0.0) << row.effect;  // nothing is impossible
    for (const FoundEffect& e : d.effects) EXPECT_LT(e.probability, 1.0);
  }
}

TEST(Calibration, DoubtsAnEffectThatHeldOutDataDoNotSetApart) {
  Diagnosis clear = diagnosis("effect", {"a"}), rivalled = clear, small = clear, left = clear, unjudged = clear;
  unjudged.gap.valid = false;
  rivalled.ranking[2].held_out_error = 1.05;  // c leaves hardly more
  small.gap.before = 1.4;
  left.gap.after = 1.8;
  calibrate(clear);
  EXPECT_GT(probability(clear, "a"), 0.9);
  for (Diagnosis* d : {&rivalled, &small, &left, &unjudged}) {
    calibrate(*d);
    EXPECT_LT(probability(*d, "a"), 0.8);
    EXPECT_NEAR(d->effects.front().probability, probability(*d, "a"), 1e-12);
    EXPECT_GT(probability(*d, "a"), probability(*d, "c"));
    EXPECT_EQ(d->reasons.size(), 1u);
  }
  EXPECT_NE(rivalled.reasons.front().find("c predicts"), std::string::npos) << rivalled.reasons.front();
}

TEST(Calibration, LetsAVerdictOfHeldOutDataOverruleThePosterior) {
  Diagnosis d = diagnosis("none", {});
  calibrate(d);
  EXPECT_EQ(d.ranking.front().effect, "none");
  EXPECT_GT(probability(d, "none"), 0.5);
  EXPECT_GT(probability(d, "a + b"), probability(d, "a"));
  EXPECT_GT(probability(d, "a"), probability(d, "c"));
}

TEST(Calibration, LeavesWhatCouldNotBeJudged) {
  Diagnosis d = diagnosis("insufficient", {});
  calibrate(d);
  EXPECT_EQ(probability(d, "a + b"), 0.9);
}

}  // namespace
}  // namespace jaculus::test
