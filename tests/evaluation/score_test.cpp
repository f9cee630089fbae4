// Marks and sums against cases worked out by hand.

#include "jaculus/evaluation/score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/estimates.h"
#include "evaluation/sheet.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus {
namespace {

SealedTruth single(const std::string& effect, std::vector<std::string> equivalent = {}) {
  SealedTruth truth;
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

SealedTruth of_kind(const std::string& kind) {
  SealedTruth truth;
  truth.kind = kind;
  truth.strength_in_noise_floors = kind == "none" ? 0.0 : 6.0;
  return truth;
}

CaseAnswer says(const std::string& verdict, const std::vector<std::pair<std::string, double>>& effects = {}) {
  CaseAnswer answer;
  answer.verdict = verdict;
  for (const auto& [name, p] : effects) {
    NamedEffect effect;
    effect.name = name;
    effect.probability = p;
    answer.effects.push_back(effect);
    answer.ranking[name] = p;
  }
  return answer;
}

TEST(Mark, CreditOfASingle) {
  const SealedTruth truth = single("tail_compliance", {"tail_backlash"});
  EXPECT_EQ(mark_answer(truth, says("effect", {{"tail_compliance", 0.9}})).credit, 1.0);
  EXPECT_EQ(mark_answer(truth, says("effect", {{"tail_backlash", 0.9}})).credit, 1.0);
  EXPECT_EQ(mark_answer(truth, says("effect", {{"wind", 0.9}})).credit, 0.0);
  EXPECT_EQ(mark_answer(truth, says("ambiguous", {{"tail_compliance", 0.5}, {"tail_backlash", 0.5}})).credit, 1.0);
  EXPECT_EQ(mark_answer(truth, says("ambiguous", {{"tail_compliance", 0.5}, {"wind", 0.5}})).credit, 0.5);
  EXPECT_NEAR(mark_answer(truth, says("ambiguous", {{"wind", 0.4}, {"tail_compliance", 0.3}, {"payload", 0.3}})).credit,
              1.0 / 3.0, 1e-15);
  for (const char* verdict : {"none", "unexplained", "insufficient", "failed"})
    EXPECT_EQ(mark_answer(truth, says(verdict)).credit, 0.0) << verdict;
}

TEST(Mark, CreditOfPairsNoneAndOutside) {
  SealedTruth pair = of_kind("pair");
  pair.effects = {"payload", "wind"};
  EXPECT_EQ(mark_answer(pair, says("several", {{"wind", 0.9}, {"payload", 0.9}})).credit, 1.0);
  EXPECT_EQ(mark_answer(pair, says("effect", {{"wind", 0.9}})).credit, 0.5);
  EXPECT_NEAR(mark_answer(pair, says("several", {{"wind", 0.9}, {"payload", 0.9}, {"late_start", 0.9}})).credit,
              2.0 / 3.0, 1e-15);
  EXPECT_EQ(mark_answer(of_kind("none"), says("none")).credit, 1.0);
  EXPECT_EQ(mark_answer(of_kind("none"), says("effect", {{"wind", 0.6}})).credit, 0.0);
  EXPECT_EQ(mark_answer(of_kind("outside"), says("unexplained")).credit, 1.0);
  EXPECT_EQ(mark_answer(of_kind("outside"), says("none")).credit, 0.0);
  SealedTruth outside = of_kind("outside");
  outside.effects = {"wind"};  // the generator's own name, which only sounds like the catalogue's
  EXPECT_EQ(mark_answer(outside, says("effect", {{"wind", 0.9}})).credit, 0.0);
}

TEST(Mark, LogScoreSumsTheClassAndHasAFloor) {
  const SealedTruth truth = single("tail_compliance", {"tail_backlash"});
  const CaseAnswer answer = says("ambiguous", {{"tail_compliance", 0.5}, {"tail_backlash", 0.3}, {"wind", 0.2}});
  EXPECT_NEAR(mark_answer(truth, answer).log_score, std::log(0.8), 1e-12);
  EXPECT_NEAR(mark_answer(truth, says("effect", {{"wind", 1.0}})).log_score, std::log(1e-3), 1e-12);
  EXPECT_NEAR(mark_answer(of_kind("none"), says("effect", {{"wind", 0.7}})).log_score, std::log(0.15), 1e-12);
  EXPECT_NEAR(mark_answer(of_kind("none"), says("none", {{"wind", 0.1}})).log_score, std::log(0.9), 1e-12);
  CaseAnswer ranked = says("effect", {{"wind", 0.7}});
  ranked.ranking["none"] = 0.25;
  EXPECT_NEAR(mark_answer(of_kind("none"), ranked).log_score, std::log(0.25), 1e-12);
}

TEST(Mark, ParametersInTheCataloguesTerms) {
  CaseAnswer answer = says("effect", {{"tail_compliance", 0.9}});
  answer.effects[0].parameters["stiffness"] = 80.0;  // 0.0125 rad/(N m), sealed 0.01
  answer.effects[0].ci95["stiffness"] = {70.0, 90.0};
  const CaseMark mark = mark_answer(single("tail_compliance"), answer);
  EXPECT_NEAR(mark.parameter_error, 0.25, 1e-12);
  EXPECT_EQ(mark.parameters_judged, 1);
  EXPECT_EQ(mark.parameters_covered, 0);
  answer.effects[0].ci95["stiffness"] = {70.0, 101.0};
  EXPECT_EQ(mark_answer(single("tail_compliance"), answer).parameters_covered, 1);
}

TEST(Mark, ComponentAndShrink) {
  CaseAnswer answer = says("effect", {{"tail_compliance", 0.9}});
  answer.components = {{"tail_transmission", 0.7}, {"body", 0.3}};
  answer.gap_after = 1.21;
  EXPECT_TRUE(mark_answer(single("tail_compliance"), answer).component_right);
  EXPECT_NEAR(mark_answer(single("tail_compliance"), answer).shrink_ratio, 1.1, 1e-12);
  answer.components["contact"] = 0.8;
  EXPECT_FALSE(mark_answer(single("tail_compliance"), answer).component_right);
}

TEST(Estimates, ClopperPearsonAgainstItsTable) {
  // 0 of 60: 1 - 0.025^(1/60); 5 of 10: published (0.1871, 0.8129).
  EXPECT_NEAR(evaluation::proportion(0, 60).ci95.upper, 1.0 - std::pow(0.025, 1.0 / 60.0), 1e-12);
  EXPECT_EQ(evaluation::proportion(0, 60).ci95.lower, 0.0);
  EXPECT_NEAR(evaluation::proportion(5, 10).ci95.lower, 0.1871, 5e-5);
  EXPECT_NEAR(evaluation::proportion(5, 10).ci95.upper, 0.8129, 5e-5);
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
  std::vector<SealedTruth> truths;
  std::map<std::string, std::vector<CaseAnswer>> answers;
};

Batch batch() {
  Batch b;
  const auto add = [&](const SealedTruth& truth, const CaseAnswer& own, const CaseAnswer& other) {
    b.truths.push_back(truth);
    b.answers["diagnosis"].push_back(own);
    b.answers["lowest training error"].push_back(other);
  };
  CaseAnswer compliance = says("effect", {{"tail_compliance", 0.9}});
  compliance.ranking["wind"] = 0.1;
  const CaseAnswer right = says("effect", {{"tail_compliance", 0.9}}), wrong = says("effect", {{"wind", 0.9}});
  for (int i = 0; i < 40; ++i) add(single("tail_compliance"), i < 36 ? right : wrong, i < 20 ? compliance : wrong);
  for (int i = 0; i < 20; ++i) add(of_kind("none"), i == 0 ? wrong : says("none"), wrong);
  for (int i = 0; i < 10; ++i) add(of_kind("outside"), says("unexplained"), wrong);
  return b;
}

TEST(Score, SumsUp) {
  const Batch b = batch();
  const Score score = score_answers(b.truths, b.answers);
  ASSERT_EQ(score.sheets.size(), 2u);
  const ScoreSheet& own = score.sheets.front();
  EXPECT_EQ(own.answerer, "diagnosis");
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

TEST(Score, BaselinesGetTheirOwnAccuracyAsConfidence) {
  Batch b = batch();
  std::vector<CaseAnswer> answers = b.answers.at("lowest training error");
  evaluation::give_confidence(b.truths, answers);
  EXPECT_NEAR(answers[0].effects[0].probability, 20.0 / 71.0, 1e-12);  // 19 hits of the other 69
  EXPECT_NEAR(answers[0].ranking.at("wind"), 1.0 - 20.0 / 71.0, 1e-12);
  EXPECT_NEAR(answers[69].effects[0].probability, 21.0 / 71.0, 1e-12);  // 20 of 69
}

TEST(Score, JsonAndText) {
  const Batch b = batch();
  Score score = score_answers(b.truths, b.answers);
  const auto json = nlohmann::json::parse(score_json(score));
  EXPECT_EQ(json.at("format"), "jaculus-score/1");
  EXPECT_EQ(json.at("cases").size(), 70u);
  EXPECT_FALSE(json.at("goals")[0].at("met").get<bool>());
  EXPECT_EQ(score_text(score).find("left out"), std::string::npos);
  score.truths[0].parted = {"foot_friction on leap", "foot_friction on leap"};
  const std::string text = score_text(score);
  EXPECT_NE(text.find("2 draws were left out"), std::string::npos);
  EXPECT_NE(text.find("credit of singles, plain gap"), std::string::npos);
  EXPECT_NE(text.find("missed"), std::string::npos);
  EXPECT_NE(text.find("lowest training error"), std::string::npos);
}

TEST(Answer, ReadsTheFormatAndKeepsItThroughText) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("diagnosis.json", R"({"format": "jaculus-diagnosis/1", "verdict": "effect",
    "effects": [{"name": "tail_compliance", "probability": 0.97,
      "parameters": {"stiffness": {"value": 98.0, "ci95": [90.0, 107.0], "unit": "N m/rad"}}}],
    "ranking": [{"effect": "tail_compliance", "log_evidence": 0, "held_out_error": 0, "probability": 0.97}],
    "where": {"components": {"tail_transmission": 0.8}},
    "gap": {"before": 5.0, "after": 1.1, "noise_floor": 0.0, "shrink": null, "ci95": [0, 1], "per_channel": {}}})");
  const CaseAnswer answer = answer_from_text(answer_to_text(read_answer(file)));
  EXPECT_EQ(answer.verdict, "effect");
  EXPECT_EQ(answer.effects.at(0).parameters.at("stiffness"), 98.0);
  EXPECT_EQ(answer.effects.at(0).ci95.at("stiffness").upper, 107.0);
  EXPECT_EQ(answer.ranking.at("tail_compliance"), 0.97);
  EXPECT_EQ(answer.components.at("tail_transmission"), 0.8);
  EXPECT_EQ(answer.gap_after, 1.1);
}

TEST(Answer, BadOnesAreNamed) {
  const test::TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    const auto file = folder.write("diagnosis.json", text);
    return test::input_error_of([&] { read_answer(file); });
  };
  EXPECT_TRUE(test::holds(message("{"), "is no JSON"));
  EXPECT_TRUE(test::holds(message("{}"), ".format: missing"));
  EXPECT_TRUE(test::holds(message(R"({"format": "jaculus-diagnosis/1", "verdict": "maybe"})"), "'maybe' given"));
  EXPECT_TRUE(test::holds(
      message(
          R"({"format": "jaculus-diagnosis/1", "verdict": "effect", "effects": [{"name": "wind", "probability": 2}]})"),
      "effects[0].probability: 2 given"));
}

}  // namespace
}  // namespace jaculus
