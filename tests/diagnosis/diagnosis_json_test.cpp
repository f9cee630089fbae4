// What diagnosis.json states, on values of which every one is known.

#include "jaculus/diagnosis/diagnosis_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "diagnosis/toy.h"
#include "jaculus/diagnosis/diagnose.h"

namespace jaculus::diagnosis {
namespace {

using Json = nlohmann::json;

/// Friction at an elbow, not told from a twin; the wrist lacks 0.08 N m.
Diagnosis friction(const effects::Effect& effect) {
  const auto problem = test::toy_problem(Vector::Zero(4));
  problem->hypotheses.candidates[0].effect = &effect;
  Diagnosis d;
  d.problem = problem;
  d.verdict = Verdict::partial;
  d.effects = {{"first", "", 0.9, {{"torque", "N m", 0.5, {0.4, 0.5}, true}}, {"twin"}},
               {"second", "", 0.9, {{"strength", "-", 0.1, {0.05, 0.15}}}, {}}};
  d.lacking = {{"wrist", 0.08, "N m", 3.0}};
  d.gap.over = "conditions";
  d.gap.by_fold = {{8.0, 1.5}, {6.0, 7.0}};
  d.agreement.sets = {{"monday", {}, {}, true}, {"tuesday", {}, {"first"}, false}};
  return d;
}

effects::Effect at_elbow() {
  effects::Effect effect;
  effect.name = "first";
  effect.joints = [](const model::PlanarModel&) { return std::vector<std::string>{"elbow"}; };
  return effect;
}

TEST(DiagnosisJson, SaysAtWhichJointsAnEffectActs) {
  const effects::Effect effect = at_elbow();
  const Json effects = Json::parse(diagnosis_json(friction(effect)))["effects"];
  EXPECT_EQ(effects[0]["at"], Json({"elbow"}));
  EXPECT_EQ(effects[1]["at"], Json::array());
}

TEST(DiagnosisJson, SaysThatAValueIsAtItsBound) {
  const effects::Effect effect = at_elbow();
  const Json effects = Json::parse(diagnosis_json(friction(effect)))["effects"];
  EXPECT_EQ(effects[0]["parameters"]["torque"]["at_bound"], true);
  EXPECT_EQ(effects[1]["parameters"]["strength"]["at_bound"], false);
}

TEST(DiagnosisJson, ListsWhatCantBeToldApartAsSets) {
  const effects::Effect effect = at_elbow();
  const Json effects = Json::parse(diagnosis_json(friction(effect)))["effects"];
  EXPECT_EQ(effects[0]["indistinguishable"], Json::parse(R"([["twin"]])"));
  EXPECT_EQ(effects[1]["indistinguishable"], Json::array());
}

TEST(DiagnosisJson, GivesWhatEachJointLacks) {
  const effects::Effect effect = at_elbow();
  const Json where = Json::parse(diagnosis_json(friction(effect)))["where"];
  EXPECT_EQ(where["joints"]["wrist"]["residual_rms"], 0.08);
  EXPECT_EQ(where["joints"]["wrist"]["unit"], "N m");
}

TEST(DiagnosisJson, GivesTheGapOfEachDataset) {
  const effects::Effect effect = at_elbow();
  Diagnosis d = friction(effect);
  const Json sets = Json::parse(diagnosis_json(d))["datasets"];
  ASSERT_EQ(sets.size(), 2u);
  EXPECT_EQ(sets[0]["name"], "monday");
  EXPECT_EQ(sets[0]["gap"]["after"], 1.5);
  EXPECT_EQ(sets[0]["agrees"], true);
  EXPECT_EQ(sets[1]["gap"]["before"], 6.0);
  EXPECT_EQ(sets[1]["agrees"], false);

  d.gap.over = "trials";  // whose folds are no datasets
  EXPECT_TRUE(Json::parse(diagnosis_json(d))["datasets"][0]["gap"]["after"].is_null());
}

}  // namespace
}  // namespace jaculus::diagnosis
