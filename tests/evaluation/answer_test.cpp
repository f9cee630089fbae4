// Answers as they are read from diagnosis.json and kept as text.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "evaluation/sample_cases.h"
#include "jaculus/evaluation/predictions.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::evaluation {
namespace {

using diagnosis::Verdict;
using test::tells;

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
