// The whole statistics on toy problems: none stays none, effects come back with intervals, classes
// are told, structure that no candidate has is not explained away, bad data are refused.

#include "jaculus/diagnosis/diagnose.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/toy.h"
#include "jaculus/diagnosis/diagnosis_json.h"

namespace jaculus::diagnosis {
namespace {

using test::toy_problem;
using test::toy_truth;
using test::ToyData;

std::vector<std::string> names(const Diagnosis& d) {
  std::vector<std::string> found;
  for (const FoundEffect& e : d.effects) found.push_back(e.name);
  std::sort(found.begin(), found.end());
  return found;
}

TEST(Diagnose, NoEffectIsNoneInAlmostEveryDraw) {
  int alarms = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    ToyData data;
    data.seed = seed;
    alarms += diagnose_problem(*toy_problem(toy_truth(0.0, 0.0), data)).verdict != Verdict::none;
  }
  EXPECT_LE(alarms, 2);
}

TEST(Diagnose, SecondEffectComesBackWithItsInterval) {
  int covered = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    ToyData data;
    data.seed = seed;
    const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.02), data));
    ASSERT_EQ(d.verdict, Verdict::effect) << diagnosis_text(d);
    ASSERT_EQ(names(d), std::vector<std::string>{"second"});
    covered += d.effects[0].parameters[0].ci95.contains(0.02);
    EXPECT_NEAR(d.effects[0].parameters[0].value, 0.02, 0.002);
    EXPECT_GT(d.gap.before, 3.0);
    EXPECT_LT(d.gap.after, 1.3);
    EXPECT_GT(*d.gap.shrink, 0.8);
  }
  EXPECT_GE(covered, 16);  // of 20 at 95 %: fewer has a chance of 3e-4
}

TEST(Diagnose, TwinsAreNotToldApart) {
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.03, 0.0)));
  EXPECT_EQ(d.verdict, Verdict::ambiguous) << diagnosis_text(d);
  EXPECT_EQ(names(d), (std::vector<std::string>{"first", "twin"}));
  ASSERT_FALSE(d.effects.empty());
  EXPECT_LT(d.effects[0].probability, 0.8);
  EXPECT_EQ(d.effects[0].indistinguishable.size(), 1u);
}

TEST(Diagnose, PairIsFound) {
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.05, 0.03)));
  EXPECT_NE(d.verdict, Verdict::effect) << diagnosis_text(d);
  const std::vector<std::string> found = names(d);
  EXPECT_NE(std::find(found.begin(), found.end(), "second"), found.end()) << diagnosis_text(d);
  EXPECT_NE(std::find(found.begin(), found.end(), "first"), found.end()) << diagnosis_text(d);
  EXPECT_LT(d.gap.after, 0.2 * d.gap.before);
}

/// A candidate `more`, which is `second` where its further parameter is nominal.
std::shared_ptr<Problem> with_more_than_second(const Vector& truth, const effects::Effect& more) {
  auto problem = toy_problem(truth);
  Hypotheses& h = problem->hypotheses;
  h.parameters.push_back({"more", "strength", "-", 0.0, 0.1, {-1.0, 1.0}});
  h.parameters.push_back({"more", "asymmetry", "-", 0.0, 0.3, {-1.0, 1.0}});
  Candidate candidate;
  candidate.name = "more";
  candidate.parameters = {4, 5};
  candidate.effect = &more;
  h.candidates.push_back(candidate);
  problem->forward = [inner = problem->forward](int dataset, int segment, const Vector& p) {
    Vector own = p.head(4);
    own[1] += p[4];
    Prediction prediction = inner(dataset, segment, own);
    const Vector time = Vector::LinSpaced(prediction.values.cols(), 0.0, 1.0);
    prediction.values.row(0) +=
        0.02 * p[4] * p[5] * (9.0 * time.array()).cos().matrix().transpose();
    return prediction;
  };
  return problem;
}

TEST(Diagnose, AnEffectIsNoRivalOfItsOwnSpecialCase) {
  effects::Effect more;
  more.name = "more";
  more.caption = "more";
  more.parameters.resize(2);
  more.special_case = "second";
  const Diagnosis d = diagnose_problem(*with_more_than_second(toy_truth(0.0, 0.05), more));
  EXPECT_EQ(d.verdict, Verdict::effect) << diagnosis_text(d);
  EXPECT_EQ(names(d), std::vector<std::string>{"second"}) << diagnosis_text(d);
  EXPECT_TRUE(d.effects[0].indistinguishable.empty()) << diagnosis_text(d);

  more.special_case.clear();
  const Diagnosis rivals = diagnose_problem(*with_more_than_second(toy_truth(0.0, 0.05), more));
  EXPECT_EQ(rivals.verdict, Verdict::ambiguous) << diagnosis_text(rivals);
}

TEST(Diagnose, ValueAtItsBoundIsSaid) {
  for (const double upper : {1.0, 0.0999}) {
    auto problem = toy_problem(toy_truth(0.0, 0.1));
    problem->hypotheses.parameters[1].bounds.upper = upper;
    const Diagnosis d = diagnose_problem(*problem);
    ASSERT_EQ(names(d), std::vector<std::string>{"second"}) << diagnosis_text(d);
    EXPECT_EQ(d.effects[0].parameters[0].at_bound, upper < 0.1) << diagnosis_text(d);
    const bool said = diagnosis_text(d).find("at its bound") != std::string::npos;
    EXPECT_EQ(said, upper < 0.1);
  }
}

TEST(Diagnose, IntervalThatItsRangeCutsIsSaid) {
  // A value of 0.1 with a deviation of some 1e-5: a range that ends within two of them cuts it.
  for (const double beyond : {0.1, 1e-5}) {
    auto problem = toy_problem(toy_truth(0.0, 0.1));
    const Diagnosis whole = diagnose_problem(*problem);
    ASSERT_EQ(names(whole), std::vector<std::string>{"second"}) << diagnosis_text(whole);
    problem->hypotheses.parameters[1].bounds.upper = whole.effects[0].parameters[0].value + beyond;
    const Diagnosis d = diagnose_problem(*problem);
    ASSERT_EQ(names(d), std::vector<std::string>{"second"}) << diagnosis_text(d);
    EXPECT_FALSE(d.effects[0].parameters[0].at_bound) << diagnosis_text(d);
    EXPECT_EQ(d.effects[0].parameters[0].cut_by_range, beyond < 0.01) << diagnosis_text(d);
  }
}

TEST(Diagnose, WhatNoCandidateHasIsUnexplained) {
  ToyData data;
  data.extra = [](int channel, double t) {
    return channel == 0 && t > 0.0 ? 0.02 * std::sin(25.0 * t) * t / 0.5 : 0.0;
  };
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.0), data));
  EXPECT_EQ(d.verdict, Verdict::unexplained) << diagnosis_text(d);
}

TEST(Diagnose, PushInOneTrialIsCutAndNotExplained) {
  ToyData data;
  data.segments = 6;
  data.pushed = 2;
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.0), data));
  ASSERT_EQ(d.disturbances.size(), 1u) << diagnosis_text(d);
  EXPECT_EQ(d.disturbances[0].segment, 2);
  EXPECT_NEAR(d.disturbances[0].onset, 0.3, 0.1);
  EXPECT_EQ(d.verdict, Verdict::none) << diagnosis_text(d);
}

TEST(Diagnose, StampsThatAreAllLateAreSaidAndNotCounted) {
  for (const double late : {0.002, 0.008}) {
    auto problem = toy_problem(Vector::Zero(4));
    for (auto& segment : problem->observations.datasets[0].segments)
      for (Vector& time : segment.time) time.array() += late;
    const Diagnosis d = diagnose_problem(*problem, {});
    EXPECT_EQ(d.verdict, Verdict::none) << late;
    const bool said = std::any_of(d.notes.begin(), d.notes.end(), [](const std::string& note) {
      return note.find("8.0 ms later") != std::string::npos;
    });
    EXPECT_EQ(said, late > 0.004);
  }
}

TEST(Diagnose, OneTrialIsNeverAStatement) {
  ToyData data;
  data.segments = 1;
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.05), data));
  EXPECT_EQ(d.verdict, Verdict::insufficient);
  EXPECT_FALSE(d.reasons.empty());
  EXPECT_TRUE(d.effects.empty());  // a fit there is, but no statement
  EXPECT_EQ(d.rule, "one trial");
}

TEST(Diagnose, InvertedChannelIsNamed) {
  auto problem = toy_problem(toy_truth(0.0, 0.0));
  for (auto& segment : problem->observations.datasets[0].segments) segment.value[0] *= -1.0;
  const Diagnosis d = diagnose_problem(*problem);
  EXPECT_EQ(d.verdict, Verdict::insufficient);
  ASSERT_FALSE(d.reasons.empty());
  EXPECT_NE(d.reasons[0].find("a looks inverted"), std::string::npos) << d.reasons[0];
}

TEST(Diagnose, DegreesAreNamed) {
  auto problem = toy_problem(toy_truth(0.0, 0.0));
  for (auto& segment : problem->observations.datasets[0].segments) segment.value[1] *= 57.29578;
  const Diagnosis d = diagnose_problem(*problem);
  EXPECT_EQ(d.verdict, Verdict::insufficient);
  ASSERT_FALSE(d.reasons.empty());
  EXPECT_NE(d.reasons[0].find("b looks like degrees"), std::string::npos) << d.reasons[0];
}

TEST(Diagnose, NoiseFloorIsTheSensors) {
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.0)));
  ASSERT_TRUE(d.noise);
  for (const ChannelNoise& channel : d.noise->datasets[0].channels) {
    EXPECT_NEAR(channel.noise_floor, 1e-3, 1e-4);
    EXPECT_LT(channel.correlation, 0.2);
  }
}

TEST(Diagnose, SimulationThatFailsIsSaid) {
  auto problem = toy_problem(toy_truth(0.0, 0.0));
  problem->forward = [](int, int, const Vector&) {
    Prediction failed;
    failed.message = "diverged at 0.1 s";
    return failed;
  };
  const Diagnosis d = diagnose_problem(*problem);
  EXPECT_EQ(d.verdict, Verdict::insufficient);
  ASSERT_FALSE(d.reasons.empty());
  EXPECT_NE(d.reasons[0].find("diverged at 0.1 s"), std::string::npos);
}

}  // namespace
}  // namespace jaculus::diagnosis
