// jaculus diagnose as a user runs it: errors in units, tolerances, shares, and what is refused.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/program.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::cli {
namespace {

using nlohmann::json;
using test::expect_refusal;
using test::holds;
using test::kProblems;
using test::Outcome;
using test::run_program;

/// A pendulum with dry friction that its model lacks, diagnosed once for all tests.
class Diagnosed : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = new test::TemporaryFolder;
    const Outcome made =
        run_program({"simulate", kProblems + "pendulum_trials.yaml", "--effect",
                     "joint_coulomb_friction:torque=0.2", "--out", *folder / "data"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const std::string few = folder->write("s.yaml", "largest_model: 1\nkept_singles: 3\n");
    outcome = run_program({"diagnose", *folder / "data", "--settings", few, "--tolerance",
                           "pendulum=1deg,pendulum_velocity=0.001 rad/s", "--horizon", "0.3s",
                           "--out", *folder / "out"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    std::ifstream stream(*folder / "out/diagnosis.json");
    answer = json::parse(stream, nullptr, false);
  }
  static void TearDownTestSuite() { delete folder; }

  static test::TemporaryFolder* folder;
  static Outcome outcome;
  static json answer;
};
test::TemporaryFolder* Diagnosed::folder = nullptr;
Outcome Diagnosed::outcome;
json Diagnosed::answer;

TEST_F(Diagnosed, GivesTheErrorInDegreesUpToTheHorizon) {
  ASSERT_EQ(answer.at("format"), "jaculus-diagnosis/2");
  const json& gap = answer.at("gap").at("physical").at("pendulum");
  EXPECT_EQ(gap.at("unit"), "deg");
  EXPECT_NEAR(gap.at("horizon_s").get<double>(), 0.3, 0.02);
  EXPECT_GT(gap.at("before").get<double>(), 2.0 * gap.at("after").get<double>());
  EXPECT_NEAR(gap.at("after").get<double>(), gap.at("floor").get<double>(),
              0.5 * gap.at("floor").get<double>());
  ASSERT_EQ(gap.at("horizons").size(), 2u);
  EXPECT_EQ(gap.at("horizons")[0].at("whole"), true);
  EXPECT_NEAR(gap.at("horizons")[0].at("horizon_s").get<double>(), 3.0, 0.05);
  EXPECT_GT(gap.at("horizons")[0].at("before").get<double>(), gap.at("before").get<double>());
}

TEST_F(Diagnosed, SaysWhetherTheModelIsGoodEnough) {
  const json& physical = answer.at("gap").at("physical");
  EXPECT_EQ(physical.at("pendulum").at("met"), true);
  EXPECT_NEAR(physical.at("pendulum").at("tolerance").get<double>(), 1.0, 1e-12);
  EXPECT_EQ(physical.at("pendulum_velocity").at("met"), false);
  EXPECT_TRUE(holds(outcome.out, "tolerance pendulum 1 deg: met by the augmented model ("));
  EXPECT_TRUE(holds(outcome.out, "no model could meet it"));
}

TEST_F(Diagnosed, SharesSumToWhatIsExplained) {
  ASSERT_FALSE(answer.at("effects").empty());
  double sum = answer.at("effects")[0].at("share").at("tolerances").get<double>();
  for (const json& effect : answer.at("effects"))
    sum += effect.at("share").at("shapley").get<double>();
  EXPECT_NEAR(sum, answer.at("gap").at("energy_explained").get<double>(), 1e-9);
}

TEST_F(Diagnosed, AnswersInThreeSentences) {
  const json& summary = answer.at("summary");
  for (const char* key : {"where", "which", "how_far"}) {
    const std::string sentence = summary.at(key);
    EXPECT_TRUE(sentence.ends_with(".")) << sentence;
    EXPECT_TRUE(holds(outcome.out, sentence));
  }
  EXPECT_TRUE(holds(summary.at("which"), "friction"));
  EXPECT_TRUE(holds(summary.at("how_far"), "deg"));
}

TEST_F(Diagnosed, DrawsTheRobotWithTheTorqueThatTheModelLacks) {
  const std::string page = test::bytes_of(*folder / "out/report.html");
  for (const char* style : {"measured", "nominal", "augmented", "force"})
    EXPECT_NE(page.find(std::string(R"("style":")") + style + '"'), std::string::npos) << style;
  EXPECT_EQ(page.find(R"("style":"assumed")"), std::string::npos);  // its joint is measured
  // Dry friction of 0.2 N m, as the arrow's text gives it.
  EXPECT_NE(page.find("N m along pendulum"), std::string::npos);
}

TEST_F(Diagnosed, RefusesBadTolerancesAndHorizons) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--tolerance", "elbow=1deg"}, "allowed: pendulum (deg)"},
      {{"--tolerance", "pendulum=1mm"}, "is in m; allowed: a number in rad"},
      {{"--tolerance", "pendulum"}, "allowed: CHANNEL=QUANTITY"},
      {{"--horizon", "0.1"}, "--horizon: '0.1' has no unit"},
      {{"--horizon", "2 mm"}, "is in m; allowed: a number in s"},
      {{"--horizon", "0 s"}, "allowed: 0.001 to 1000 s"}};
  for (const auto& [flags, message] : cases) {
    std::vector<std::string> arguments = {"diagnose", *folder / "data"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const Outcome refused = run_program(arguments);
    expect_refusal(refused);
    EXPECT_TRUE(holds(refused.err, message));
  }
}

}  // namespace
}  // namespace jaculus::cli
