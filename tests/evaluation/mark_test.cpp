// Marks of single cases, worked out by hand.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/sample_cases.h"
#include "jaculus/evaluation/case_scores.h"

namespace jaculus::evaluation {
namespace {

using diagnosis::Verdict;
using test::of_kind;
using test::push;
using test::says;
using test::single;
using test::tells;

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

TEST(Mark, NamedAndMoreIsNamed) {
  const auto named = [](CaseTruth truth, std::vector<std::string> effects) {
    truth.effects = std::move(effects);
    return score_case(truth, says(Verdict::partial, {{"wind", 0.9}}));
  };
  const CaseScore mixed = named(of_kind("mixed"), {"wind"});
  EXPECT_EQ(mixed.credit, 1.0);
  EXPECT_TRUE(mixed.right);
  EXPECT_NEAR(mixed.confidence, 0.9, 1e-12);
  EXPECT_EQ(mixed.stated, "wind + more");
  EXPECT_FALSE(named(of_kind("mixed"), {"payload"}).right);
  EXPECT_EQ(named(of_kind("mixed"), {"payload"}).credit, 0.0);

  // Nothing more acts beside a single; one of a pair is named and more does.
  EXPECT_EQ(named(of_kind("single"), {"wind"}).credit, 1.0);
  EXPECT_FALSE(named(of_kind("single"), {"wind"}).right);
  EXPECT_EQ(named(of_kind("several"), {"wind", "payload"}).credit, 0.5);
  EXPECT_TRUE(named(of_kind("several"), {"wind", "payload"}).right);
  // Where nothing acts it is a false alarm, and a push or an outside cause is no effect.
  for (const char* kind : {"none", "outside", "event"}) {
    EXPECT_EQ(named(of_kind(kind), {}).credit, 0.0) << kind;
    EXPECT_FALSE(named(of_kind(kind), {}).right) << kind;
    EXPECT_NEAR(named(of_kind(kind), {}).confidence, 0.9, 1e-12) << kind;
  }
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

}  // namespace
}  // namespace jaculus::evaluation
