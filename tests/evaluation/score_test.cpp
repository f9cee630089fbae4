// Marks and sums against cases worked out by hand.

#include "jaculus/evaluation/score.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/estimates.h"
#include "evaluation/goals.h"
#include "evaluation/metrics.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::evaluation {
namespace {

using diagnosis::Verdict;

CaseTruth single(const std::string& effect, std::vector<std::string> equivalent = {}) {
  CaseTruth truth;
  truth.case_id = "case";
  truth.kind = "single";
  truth.effects = {effect};
  truth.parameters = {{0.01, kNaN}};
  truth.strength_in_noise_floors = 5.0;
  truth.equivalent = std::move(equivalent);
  truth.component = "tail_transmission";
  truth.possible_after_gap = 1.1;
  return truth;
}

CaseTruth of_kind(const std::string& kind) {
  CaseTruth truth;
  truth.kind = kind;
  truth.strength_in_noise_floors = kind == "none" ? 0.0 : 6.0;
  return truth;
}

Prediction says(std::optional<Verdict> verdict,
                const std::vector<std::pair<std::string, double>>& effects = {}) {
  Prediction prediction;
  prediction.verdict = verdict;
  for (const auto& [name, p] : effects) {
    NamedEffect effect;
    effect.name = name;
    effect.probability = p;
    prediction.effects.push_back(effect);
    prediction.ranking[name] = p;
  }
  return prediction;
}

TEST(Mark, CreditOfASingle) {
  const CaseTruth truth = single("tail_compliance", {"tail_backlash"});
  EXPECT_EQ(score_case(truth, says(Verdict::effect, {{"tail_compliance", 0.9}})).credit, 1.0);
  EXPECT_EQ(score_case(truth, says(Verdict::effect, {{"tail_backlash", 0.9}})).credit, 1.0);
  EXPECT_EQ(score_case(truth, says(Verdict::effect, {{"wind", 0.9}})).credit, 0.0);
  EXPECT_EQ(score_case(truth,
                       says(Verdict::ambiguous, {{"tail_compliance", 0.5}, {"tail_backlash", 0.5}}))
                .credit,
            1.0);
  EXPECT_EQ(
      score_case(truth, says(Verdict::ambiguous, {{"tail_compliance", 0.5}, {"wind", 0.5}})).credit,
      0.5);
  EXPECT_NEAR(score_case(truth, says(Verdict::ambiguous,
                                     {{"wind", 0.4}, {"tail_compliance", 0.3}, {"payload", 0.3}}))
                  .credit,
              1.0 / 3.0, 1e-15);
  for (const Verdict verdict : {Verdict::none, Verdict::unexplained, Verdict::insufficient})
    EXPECT_EQ(score_case(truth, says(verdict)).credit, 0.0) << to_text(verdict);
  EXPECT_EQ(score_case(truth, says(std::nullopt)).credit, 0.0) << "no answer";
}

TEST(Mark, CreditOfPairsNoneAndOutside) {
  CaseTruth pair = of_kind("pair");
  pair.effects = {"payload", "wind"};
  EXPECT_EQ(score_case(pair, says(Verdict::several, {{"wind", 0.9}, {"payload", 0.9}})).credit,
            1.0);
  EXPECT_EQ(score_case(pair, says(Verdict::effect, {{"wind", 0.9}})).credit, 0.5);
  EXPECT_NEAR(score_case(pair, says(Verdict::several,
                                    {{"wind", 0.9}, {"payload", 0.9}, {"late_start", 0.9}}))
                  .credit,
              2.0 / 3.0, 1e-15);
  EXPECT_EQ(score_case(of_kind("none"), says(Verdict::none)).credit, 1.0);
  EXPECT_EQ(score_case(of_kind("none"), says(Verdict::effect, {{"wind", 0.6}})).credit, 0.0);
  EXPECT_EQ(score_case(of_kind("outside"), says(Verdict::unexplained)).credit, 1.0);
  EXPECT_EQ(score_case(of_kind("outside"), says(Verdict::none)).credit, 0.0);
  CaseTruth outside = of_kind("outside");
  outside.effects = {"wind"};  // the generator's own name, which only sounds like the catalogue's
  EXPECT_EQ(score_case(outside, says(Verdict::effect, {{"wind", 0.9}})).credit, 0.0);
}

TEST(Mark, LogScoreSumsTheClassAndHasAFloor) {
  const CaseTruth truth = single("tail_compliance", {"tail_backlash"});
  const Prediction prediction =
      says(Verdict::ambiguous, {{"tail_compliance", 0.5}, {"tail_backlash", 0.3}, {"wind", 0.2}});
  EXPECT_NEAR(score_case(truth, prediction).log_score, std::log(0.8), 1e-12);
  EXPECT_NEAR(score_case(truth, says(Verdict::effect, {{"wind", 1.0}})).log_score, std::log(1e-3),
              1e-12);
  EXPECT_NEAR(score_case(of_kind("none"), says(Verdict::effect, {{"wind", 0.7}})).log_score,
              std::log(0.15), 1e-12);
  EXPECT_NEAR(score_case(of_kind("none"), says(Verdict::none, {{"wind", 0.1}})).log_score,
              std::log(0.9), 1e-12);
  Prediction ranked = says(Verdict::effect, {{"wind", 0.7}});
  ranked.ranking["none"] = 0.25;
  EXPECT_NEAR(score_case(of_kind("none"), ranked).log_score, std::log(0.25), 1e-12);
}

TEST(Mark, ParametersInTheCataloguesTerms) {
  Prediction prediction = says(Verdict::effect, {{"tail_compliance", 0.9}});
  prediction.effects[0].parameters["stiffness"] = 80.0;  // 0.0125 rad/(N m), in truth 0.01
  prediction.effects[0].ci95["stiffness"] = {70.0, 90.0};
  const CaseScore score = score_case(single("tail_compliance"), prediction);
  EXPECT_NEAR(score.parameter_error, 0.25, 1e-12);
  EXPECT_EQ(score.parameters_judged, 1);
  EXPECT_EQ(score.parameters_covered, 0);
  prediction.effects[0].ci95["stiffness"] = {70.0, 101.0};
  EXPECT_EQ(score_case(single("tail_compliance"), prediction).parameters_covered, 1);
}

TEST(Mark, ComponentAndShrink) {
  Prediction prediction = says(Verdict::effect, {{"tail_compliance", 0.9}});
  prediction.components = {{"tail_transmission", 0.7}, {"body", 0.3}};
  prediction.gap_after = 1.21;
  EXPECT_TRUE(score_case(single("tail_compliance"), prediction).component_right);
  EXPECT_NEAR(score_case(single("tail_compliance"), prediction).shrink_ratio, 1.1, 1e-12);
  prediction.components["contact"] = 0.8;
  EXPECT_FALSE(score_case(single("tail_compliance"), prediction).component_right);
}

CaseTruth push() {
  CaseTruth truth = of_kind("event");
  truth.events = {{"elbow", 0.40, 0.60, -2.0}};
  truth.trials = 4;
  return truth;
}

/// Nothing named, and a push of this middle and peak.
Prediction tells(double middle, double peak, const std::string& joint = "elbow",
                 const std::string& trial = "trial_01") {
  Prediction prediction = says(Verdict::none);
  prediction.ranking["none"] = 0.9;
  prediction.events = {{trial, joint, middle - 0.05, middle + 0.05, peak}};
  return prediction;
}

TEST(Mark, AnEventIsToldByJointMiddlePeakAndSign) {
  EXPECT_EQ(score_case(push(), tells(0.5, -2.0)).credit, 1.0);
  EXPECT_EQ(score_case(push(), tells(0.59, -2.59)).credit, 1.0);
  EXPECT_EQ(score_case(push(), tells(0.61, -2.0)).credit, 0.0) << "too late";
  EXPECT_EQ(score_case(push(), tells(0.5, -2.61)).credit, 0.0) << "too strong";
  EXPECT_EQ(score_case(push(), tells(0.5, 2.0)).credit, 0.0) << "the other way";
  EXPECT_EQ(score_case(push(), tells(0.5, -2.0, "shoulder")).credit, 0.0) << "another joint";

  Prediction named = tells(0.5, -2.0);
  named.verdict = Verdict::effect;
  named.effects = {{"payload", 0.6, {}, {}}};
  EXPECT_EQ(score_case(push(), named).credit, 0.0) << "something else is named";
  EXPECT_EQ(score_case(push(), named).events_found, 1);
}

TEST(Mark, AnEventThatIsNotToldIsNoNone) {
  const CaseScore missed = score_case(push(), tells(0.8, -2.0));
  EXPECT_FALSE(missed.right);
  EXPECT_EQ(missed.confidence, 0.9);
  EXPECT_NEAR(missed.log_score, std::log(1e-3), 1e-12);
  EXPECT_EQ(missed.events_invented, 1);
  EXPECT_NEAR(score_case(push(), tells(0.5, -2.0)).log_score, 0.0, 1e-12)
      << "none and what none leaves: no effect is named";
}

TEST(Mark, AnEventCountsOnceACaseAndOnceATrial) {
  Prediction prediction = tells(0.5, -2.0);
  prediction.events.push_back({"trial_02", "elbow", 0.4, 0.6, -2.1});
  const CaseScore everywhere = score_case(push(), prediction);
  EXPECT_EQ(everywhere.events_found, 1);
  EXPECT_EQ(everywhere.events_invented, 0);
  prediction.events.push_back({"trial_02", "elbow", 0.41, 0.6, -2.1});
  EXPECT_EQ(score_case(push(), prediction).events_invented, 1);
  EXPECT_EQ(score_case(of_kind("none"), prediction).events_invented, 3);
}

TEST(Mark, SeveralAreTwoOrThree) {
  CaseTruth three = of_kind("several");
  three.effects = {"payload", "wind", "late_start"};
  const auto named = [&](const std::vector<std::pair<std::string, double>>& effects) {
    return score_case(three, says(Verdict::several, effects));
  };
  EXPECT_TRUE(named({{"wind", 0.9}, {"payload", 0.9}, {"late_start", 0.9}}).right);
  EXPECT_EQ(named({{"wind", 0.9}, {"payload", 0.9}, {"late_start", 0.9}}).credit, 1.0);
  EXPECT_NEAR(named({{"wind", 0.9}, {"payload", 0.9}}).credit, 2.0 / 3.0, 1e-15);
  EXPECT_FALSE(named({{"wind", 0.9}, {"payload", 0.9}}).right);

  Prediction ranked = says(Verdict::several, {{"wind", 0.9}, {"payload", 0.9}});
  ranked.ranking = {{"late_start + payload + wind", 0.25}, {"payload + wind", 0.5}};
  EXPECT_NEAR(score_case(three, ranked).log_score, std::log(0.25), 1e-12);
  three.kind = "pair";
  three.effects.pop_back();
  EXPECT_NEAR(score_case(three, ranked).log_score, std::log(0.5), 1e-12);
}

TEST(Mark, AnEffectAtOneJointIsNamedThereOrWithoutJoints) {
  CaseTruth truth = single("joint_coulomb_friction@elbow");
  truth.parameters = {{0.2}};
  const auto at = [&](const std::vector<std::string>& joints) {
    Prediction prediction = says(Verdict::effect, {{"joint_coulomb_friction", 0.9}});
    prediction.effects[0].joints = joints;
    prediction.effects[0].parameters["torque"] = 0.3;
    return score_case(truth, prediction);
  };
  EXPECT_EQ(at({}).credit, 1.0);
  EXPECT_EQ(at({"shoulder", "elbow"}).credit, 1.0);
  EXPECT_NEAR(at({"elbow"}).log_score, std::log(0.9), 1e-12);
  EXPECT_NEAR(at({"elbow"}).parameter_error, 0.5, 1e-12);
  EXPECT_EQ(at({"shoulder"}).credit, 0.0);
  EXPECT_FALSE(at({"shoulder"}).right);
  EXPECT_NEAR(at({"shoulder"}).log_score, std::log(1e-3), 1e-12);
  EXPECT_TRUE(std::isnan(at({"shoulder"}).parameter_error));
  EXPECT_EQ(score_case(truth, says(Verdict::effect, {{"joint_viscous_friction", 0.9}})).credit,
            0.0);
}

TEST(Mark, WhoGivesNoProbabilityScoresAtTheFloor) {
  for (const std::optional<Verdict> verdict :
       {std::optional<Verdict>(), std::optional<Verdict>(Verdict::insufficient)})
    EXPECT_NEAR(score_case(of_kind("none"), says(verdict)).log_score, std::log(1e-3), 1e-12);
}

TEST(Estimates, WilsonAgainstItsTable) {
  // 0 of 60: z^2/(60 + z^2); 5 of 10: published (0.2366, 0.7634).
  EXPECT_NEAR(evaluation::proportion(0, 60).ci95.upper, 3.8414588 / 63.8414588, 1e-7);
  EXPECT_NEAR(evaluation::proportion(0, 60).ci95.lower, 0.0, 1e-15);
  EXPECT_NEAR(evaluation::proportion(5, 10).ci95.lower, 0.2366, 5e-5);
  EXPECT_NEAR(evaluation::proportion(5, 10).ci95.upper, 0.7634, 5e-5);
  EXPECT_EQ(evaluation::proportion(0, 0).count, 0);
}

TEST(Estimates, MedianByOrderStatistics) {
  std::vector<double> values;
  for (int i = 1; i <= 20; ++i) values.push_back(i);
  const ScoreEstimate e = evaluation::median(values);
  EXPECT_EQ(e.value, 10.5);
  EXPECT_EQ(e.ci95.lower, 6.0);  // binomial(20, 1/2): 6 and 15 cover 95.9 %
  EXPECT_EQ(e.ci95.upper, 15.0);
  EXPECT_TRUE(std::isinf(evaluation::median({1.0, 2.0, 3.0}).ci95.upper));
}

/// 40 singles of which the diagnosis gets 36, 20 without effect of which it blames one, 10 outside.
struct Batch {
  std::vector<CaseTruth> truths;
  std::map<std::string, std::vector<Prediction>> predictions;
};

Batch batch() {
  Batch b;
  const auto add = [&](const CaseTruth& truth, const Prediction& own, const Prediction& other) {
    b.truths.push_back(truth);
    b.predictions["diagnosis"].push_back(own);
    b.predictions["lowest training error"].push_back(other);
  };
  Prediction compliance = says(Verdict::effect, {{"tail_compliance", 0.9}});
  compliance.ranking["wind"] = 0.1;
  const Prediction right = says(Verdict::effect, {{"tail_compliance", 0.9}}),
                   wrong = says(Verdict::effect, {{"wind", 0.9}});
  for (int i = 0; i < 40; ++i)
    add(single("tail_compliance"), i < 36 ? right : wrong, i < 20 ? compliance : wrong);
  for (int i = 0; i < 20; ++i) add(of_kind("none"), i == 0 ? wrong : says(Verdict::none), wrong);
  for (int i = 0; i < 10; ++i) add(of_kind("outside"), says(Verdict::unexplained), wrong);
  return b;
}

TEST(Score, SumsUp) {
  const Batch b = batch();
  const Score score = score_predictions(b.truths, b.predictions);
  ASSERT_EQ(score.metrics.size(), 2u);
  const Metrics& own = score.metrics.front();
  EXPECT_EQ(own.predictor, "diagnosis");
  EXPECT_NEAR(own.by.at("credit of singles, plain gap").value, 0.9, 1e-12);
  EXPECT_NEAR(own.by.at("false alarms where there is nothing").value, 0.05, 1e-12);
  EXPECT_EQ(own.by.at("outside effects called unexplained, plain gap").value, 1.0);
  EXPECT_NEAR(own.by.at("wrong and confident").value, 5.0 / 70.0, 1e-12);
  EXPECT_EQ(own.confusion.at("tail_compliance").at("wind"), 4);
  EXPECT_EQ(own.confusion.at("none").at("none"), 19);
  // Stated 0.9 on 40 singles and one false alarm, 36 right.
  const auto bin = std::find_if(own.reliability.begin(), own.reliability.end(),
                                [](const ReliabilityBin& r) { return r.probability.lower == 0.9; });
  ASSERT_NE(bin, own.reliability.end());
  EXPECT_EQ(bin->right.count, 41);
  EXPECT_NEAR(bin->right.value, 36.0 / 41.0, 1e-12);
  EXPECT_NEAR(score.comparisons.front().accuracy_gain.value, (16 + 19 + 10) / 70.0, 1e-12);
  EXPECT_GT(score.comparisons.front().accuracy_gain.ci95.lower, 0.4);
}

TEST(Score, MixedCasesAskForTheNameAndForTheRemainder) {
  CaseTruth truth = single("tail_compliance");
  truth.kind = "mixed";
  truth.beside = {"tether"};
  truth.strengths = {5.0, 5.0};
  Prediction named = says(Verdict::effect, {{"tail_compliance", 0.9}});
  Prediction complete = named;
  complete.remainder = true;

  const Score score = score_predictions({truth, truth}, {{"diagnosis", {named, complete}}});
  const auto& by = score.metrics.front().by;
  EXPECT_EQ(by.at("mixed: named part named, plain gap").value, 1.0);
  EXPECT_EQ(by.at("mixed: remainder said, plain gap").value, 0.5);

  truth.strengths = {5.0, 2.0};  // what is beside it does not show by itself
  const Score weak = score_predictions({truth, truth}, {{"diagnosis", {named, named}}});
  EXPECT_EQ(weak.metrics.front().by.at("mixed: remainder said, plain gap").count, 0);
}

TEST(Score, LegsThatPartAreAClassOfTheirOwn) {
  CaseTruth parted = of_kind("none");
  parted.legs_apart = 0.03;
  Prediction unexplained = says(Verdict::unexplained);
  unexplained.remainder = true;

  const Score score = score_predictions({parted, of_kind("none")},
                                        {{"diagnosis", {unexplained, says(Verdict::none)}}});
  const Metrics& own = score.metrics.front();
  EXPECT_TRUE(own.scores[0].right);
  EXPECT_EQ(own.by.at("legs that part called unexplained").value, 1.0);
  EXPECT_EQ(own.by.at("false alarms where there is nothing").count, 1);
  EXPECT_EQ(own.by.at("remainder said where there is none").value, 0.0);
}

TEST(Score, AGoalIsMetByTheNearEndOfTheInterval) {
  // 60 of 60 without alarm: the upper end is 0.060, so that 0.03 is not shown.
  std::vector<CaseTruth> truths(60, of_kind("none"));
  const Score score =
      score_predictions(truths, {{"diagnosis", std::vector<Prediction>(60, says(Verdict::none))}});
  const auto json = nlohmann::json::parse(score_json(score));
  const auto& goals = json.at("goals");
  const auto found = std::find_if(goals.begin(), goals.end(), [](const auto& goal) {
    return goal.at("what") == "false alarms where there is nothing";
  });
  ASSERT_NE(found, goals.end());
  EXPECT_FALSE(found->at("met").get<bool>());
}

TEST(Score, GoalsAreMissedFirstAndSayTheirAim) {
  // 200 singles all right at 0.97: credit and calibration are met, coverage of all of them is too
  // much, and no baseline was run.
  Prediction right = says(Verdict::effect, {{"tail_compliance", 0.97}});
  right.effects[0].parameters["stiffness"] = 100.0;
  right.effects[0].ci95["stiffness"] = {90.0, 110.0};
  const std::vector<CaseTruth> truths(200, single("tail_compliance"));
  const Score score = score_predictions(truths, {{"diagnosis", std::vector(200, right)}});
  const std::vector<GoalResult> goals = goal_results(score);

  ASSERT_EQ(goals.size(), 11u);
  EXPECT_EQ(goals[0].what, "parameters covered by their intervals");
  EXPECT_EQ(goals[0].met, false);
  EXPECT_EQ(aim_text(goals[0]), "0.93 to 0.97");
  EXPECT_FALSE(goals[1].met.has_value());
  EXPECT_EQ(goals.back().met, true);
  const auto of = [&](const std::string& what) {
    return *std::find_if(goals.begin(), goals.end(), [&](const auto& g) { return g.what == what; });
  };
  EXPECT_EQ(of("calibration error").met, true);
  EXPECT_NEAR(of("calibration error").reached.value, 0.03, 1e-12);
  EXPECT_FALSE(of("log score over every baseline").met.has_value());
  const std::string text = score_text(score);
  EXPECT_LT(text.find("missed "), text.find("not judged "));
  EXPECT_LT(text.find("not judged "), text.find("met "));
}

TEST(Score, CoverageIsMetWhereItsWholeIntervalLiesWithin) {
  Prediction held = says(Verdict::effect, {{"tail_compliance", 0.97}});
  held.effects[0].parameters["stiffness"] = 100.0;
  held.effects[0].ci95["stiffness"] = {90.0, 110.0};
  Prediction missed = held;
  missed.effects[0].ci95["stiffness"] = {101.0, 110.0};
  const auto met = [&](int cases) {
    std::vector<Prediction> predictions;
    for (int i = 0; i < cases; ++i) predictions.push_back(i % 20 == 0 ? missed : held);
    const std::vector<CaseTruth> truths(predictions.size(), single("tail_compliance"));
    for (const GoalResult& goal :
         goal_results(score_predictions(truths, {{"diagnosis", predictions}})))
      if (goal.what == "parameters covered by their intervals") return goal.met;
    return std::optional<bool>();
  };
  EXPECT_EQ(met(100), false) << "0.95, but the interval reaches beyond";
  EXPECT_EQ(met(1000), true);
}

TEST(Score, ABaselineThatIsAsGoodIsNotBeaten) {
  const std::vector<CaseTruth> truths(20, of_kind("none"));
  const std::vector<Prediction> same(20, says(Verdict::none));
  const Score score =
      score_predictions(truths, {{"diagnosis", same}, {"lowest training error", same}});
  for (const GoalResult& goal : goal_results(score))
    if (goal.what == "log score over lowest training error") {
      EXPECT_EQ(goal.met, false);
      EXPECT_EQ(aim_text(goal), "above 0");
      return;
    }
  FAIL() << "no such goal";
}

TEST(Score, CalibrationErrorHasABootstrapInterval) {
  std::vector<CaseTruth> truths(40, single("tail_compliance"));
  std::vector<Prediction> predictions(40, says(Verdict::effect, {{"tail_compliance", 0.6}}));
  for (int i = 0; i < 20; ++i) truths[i] = single("wind");  // half are wrong
  const Score score = score_predictions(truths, {{"diagnosis", predictions}});
  const ScoreEstimate& e = score.metrics.front().by.at("calibration error");
  EXPECT_NEAR(e.value, 0.1, 1e-12);
  // A binomial share of 40 at one half: 0.345 to 0.655 with 95 %, so distances up to about 0.25.
  EXPECT_GT(e.ci95.upper, 0.2);
  EXPECT_LT(e.ci95.upper, 0.3);
  EXPECT_LT(e.ci95.lower, 0.03);
}

TEST(Score, EventsAndRemaindersAreCountedByTheirKinds) {
  Prediction cried = says(Verdict::unexplained);
  cried.remainder = true;
  const std::vector<CaseTruth> truths = {push(), push(), of_kind("outside"), of_kind("none")};
  const Score score = score_predictions(
      truths, {{"diagnosis", {tells(0.5, -2.0), tells(0.8, -2.0), cried, cried}}});
  const auto& by = score.metrics.front().by;
  EXPECT_EQ(by.at("events found").value, 0.5);
  EXPECT_EQ(by.at("events found").count, 2);
  EXPECT_NEAR(by.at("false events a trial").value, 0.125, 1e-12);  // one in 4 trials of two cases
  EXPECT_EQ(by.at("remainder said where there is one").count, 1);
  EXPECT_EQ(by.at("remainder said where there is none").count, 1);
  EXPECT_EQ(by.at("remainder said where there is none").value, 1.0);
}

TEST(Score, EightTenthsExactlyAreConfident) {
  const Score score = score_predictions({of_kind("none")},
                                        {{"diagnosis", {says(Verdict::effect, {{"wind", 0.8}})}}});
  EXPECT_EQ(score.metrics.front().by.at("wrong and confident").value, 1.0);
}

TEST(Score, StatementsOfNoneGetTheirOwnFrequency) {
  std::vector<CaseTruth> truths(10, of_kind("none"));
  truths[0] = truths[1] = single("wind");
  Prediction none = says(Verdict::none);
  none.ranking = {{"none", 0.0}, {"unexplained", 0.0}, {"wind", 0.0}};
  std::vector<Prediction> predictions(10, none);
  evaluation::give_confidence(truths, predictions);
  EXPECT_NEAR(predictions[9].ranking.at("none"), 8.0 / 11.0, 1e-12);  // 7 of the other 9
  EXPECT_NEAR(predictions[0].ranking.at("wind"), (1.0 - 9.0 / 11.0) / 2.0, 1e-12);
}

TEST(Score, BaselinesGetTheirOwnAccuracyAsConfidence) {
  Batch b = batch();
  std::vector<Prediction> predictions = b.predictions.at("lowest training error");
  evaluation::give_confidence(b.truths, predictions);
  EXPECT_NEAR(predictions[0].effects[0].probability, 20.0 / 71.0,
              1e-12);  // 19 hits of the other 69
  EXPECT_NEAR(predictions[0].ranking.at("wind"), 1.0 - 20.0 / 71.0, 1e-12);
  EXPECT_NEAR(predictions[69].effects[0].probability, 21.0 / 71.0, 1e-12);  // 20 of 69
}

TEST(Score, JsonAndText) {
  const Batch b = batch();
  Score score = score_predictions(b.truths, b.predictions);
  const auto json = nlohmann::json::parse(score_json(score));
  EXPECT_EQ(json.at("format"), "jaculus-score/1");
  EXPECT_EQ(json.at("cases").size(), 70u);
  EXPECT_FALSE(json.at("goals")[0].at("met").get<bool>());
  EXPECT_EQ(score_text(score).find("left out"), std::string::npos);
  score.truths[0].diverged = {"foot_friction on leap", "foot_friction on leap"};
  const std::string text = score_text(score);
  EXPECT_NE(text.find("2 draws were left out"), std::string::npos);
  EXPECT_NE(text.find("credit of singles, plain gap"), std::string::npos);
  EXPECT_NE(text.find("missed"), std::string::npos);
  EXPECT_NE(text.find("lowest training error"), std::string::npos);
}

TEST(Answer, ReadsTheFormatAndKeepsItThroughText) {
  const test::TemporaryFolder folder;
  const auto file =
      folder.write("diagnosis.json", R"({"format": "jaculus-diagnosis/1", "verdict": "effect",
    "effects": [{"name": "tail_compliance", "probability": 0.97,
      "parameters": {"stiffness": {"value": 98.0, "ci95": [90.0, 107.0], "unit": "N m/rad"}}}],
    "ranking": [{"effect": "tail_compliance", "log_evidence": 0, "held_out_error": 0, )"
                                     R"("probability": 0.97}],
    "where": {"components": {"tail_transmission": 0.8}},
    "gap": {"before": 5.0, "after": 1.1, "noise_floor": 0.0, "shrink": null, "ci95": [0, 1], )"
                                     R"("per_channel": {}}})");
  const Prediction prediction = prediction_from_text(prediction_to_text(read_prediction(file)));
  EXPECT_EQ(prediction.verdict, Verdict::effect);
  EXPECT_EQ(prediction.effects.at(0).parameters.at("stiffness"), 98.0);
  EXPECT_EQ(prediction.effects.at(0).ci95.at("stiffness").upper, 107.0);
  EXPECT_EQ(prediction.ranking.at("tail_compliance"), 0.97);
  EXPECT_EQ(prediction.components.at("tail_transmission"), 0.8);
  EXPECT_EQ(prediction.gap_after, 1.1);
}

TEST(Answer, TakesTheGapInUnitsWhereItIsGiven) {
  const test::TemporaryFolder folder;
  const Prediction prediction = read_prediction(
      folder.write("diagnosis.json", R"({"format": "jaculus-diagnosis/2", "verdict": "none",
    "where": {"channels": {"x": {"noise_floor": 0.5, "unit": "m"}}},
    "gap": {"physical": {"x": {"unit": "mm", "before": 7.0, "after": 2.0}},
            "per_channel": {"mocap.x": {"before": 3.0, "after": 1.0}}}})"));
  EXPECT_EQ(prediction.channels.at("x").unit, "mm");
  EXPECT_EQ(prediction.channels.at("x").before, 7.0);
  EXPECT_EQ(prediction.channels.at("x").after, 2.0);
}

TEST(Answer, KeepsJointsAndEvents) {
  Prediction prediction = tells(0.5, -2.0);
  prediction.effects = {{"joint_coulomb_friction", 0.9, {}, {}, {"elbow"}}};
  prediction.events.push_back({"trial_02", "base", kNaN, 0.2, 1.0});
  const Prediction again = prediction_from_text(prediction_to_text(prediction));
  EXPECT_EQ(again.effects.at(0).joints, std::vector<std::string>{"elbow"});
  ASSERT_EQ(again.events.size(), 2u);
  EXPECT_EQ(again.events[0].joint, "elbow");
  EXPECT_EQ(again.events[0].peak, -2.0);
  EXPECT_TRUE(std::isnan(again.events[1].from));
}

TEST(Answer, BadOnesAreNamed) {
  const test::TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    const auto file = folder.write("diagnosis.json", text);
    return test::input_error_of([&] { read_prediction(file); });
  };
  EXPECT_TRUE(test::holds(message("{"), "is no JSON"));
  EXPECT_TRUE(test::holds(message("{}"), ".format: missing"));
  EXPECT_TRUE(test::holds(message(R"({"format": "jaculus-diagnosis/1", "verdict": "maybe"})"),
                          "'maybe' given"));
  EXPECT_TRUE(test::holds(
      message(
          R"({"format": "jaculus-diagnosis/1", "verdict": "effect", "effects": [{"name": "wind", )"
          R"("probability": 2}]})"),
      "effects[0].probability: 2 given"));
}

}  // namespace
}  // namespace jaculus::evaluation
