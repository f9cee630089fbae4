// Effects that users write, as a user runs them: checked, simulated, diagnosed, and simulated again
// with what was found.

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

const char* const kCogging = R"yaml(format: jaculus-effect/1
name: my_cogging
caption: torque at the pendulum that repeats with its angle
at: {joint: pendulum}
parameters:
  sine: {unit: N m, nominal: 0, bounds: [-1, 1], scale: 0.1}
  period: {unit: rad, nominal: 0.35, bounds: [0.2, 0.6], scale: 0.02}
torque: "sine*sin(2*pi*q/period)"
)yaml";

const std::string kExperiment = kProblems + "pendulum_trials.yaml";

TEST(UserEffect, IsCheckedInAnExperiment) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("own.yaml", kCogging);
  const Outcome outcome = run_program({"check", file, "--experiment", kExperiment, "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
  const json answer = json::parse(outcome.out);
  ASSERT_GE(answer.at(0).at("checks").size(), 5u);
  for (const json& check : answer.at(0).at("checks")) EXPECT_TRUE(check.at("passed")) << check;

  const Outcome nowhere = run_program({"check", file});
  expect_refusal(nowhere);
  EXPECT_TRUE(holds(nowhere.err, "own.yaml: no experiment to try it in; allowed: --experiment"));
  const Outcome other =
      run_program({"check", file, "--experiment", kProblems + "bench_trials.yaml"});
  expect_refusal(other);
  EXPECT_TRUE(holds(other.err, "own.yaml:4: at: the robot has no joint 'pendulum'"));
}

TEST(UserEffect, ThatFailsACheckEndsWithOne) {
  const test::TemporaryFolder folder;
  std::string text = kCogging;
  text.replace(text.find("\"sine*sin(2*pi*q/period)\""), 25,
               "\"sine*(t > 1000*t ? 1 : 0)*period/period\"");
  const std::string file = folder.write("own.yaml", text);
  const Outcome outcome = run_program({"check", file, "--experiment", kExperiment});
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "FAILED"));
}

TEST(UserEffect, IsSimulatedDiagnosedAndSimulatedAgain) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("own.yaml", kCogging), data = folder / "data";
  const Outcome made = run_program({"simulate", kExperiment, "--effects", file, "--effect",
                                    "my_cogging:sine=0.25", "--out", data});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_TRUE(holds(made.out, "effects: my_cogging sine=0.25 N m period=0.35 rad"));

  const std::string few = folder.write("s.yaml", "largest_model: 1\nkept_singles: 3\n");
  const Outcome outcome = run_program(
      {"diagnose", data, "--settings", few, "--effects", file, "--out", folder / "out"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::ifstream stream(folder / "out/diagnosis.json");
  const json answer = json::parse(stream);
  ASSERT_EQ(answer.at("effects").size(), 1u) << answer.at("effects");
  const json& effect = answer.at("effects")[0];
  EXPECT_EQ(effect.at("name"), "my_cogging");
  EXPECT_NEAR(effect.at("parameters").at("sine").at("value").get<double>(), 0.25, 0.02);

  const Outcome again =
      run_program({"simulate", kExperiment, "--augmented", folder / "out/augmented.yaml"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(holds(again.out, "effects: my_cogging sine=0.2"));
}

TEST(UserEffect, OfABadFileIsRefusedByEveryCommand) {
  const test::TemporaryFolder folder;
  std::string text = kCogging;
  text.replace(text.find("/period"), 7, "/peroid");
  const std::string file = folder.write("own.yaml", text);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"check", file},
        {"simulate", kExperiment, "--effects", file, "--effect", "my_cogging:sine=0.25"}}) {
    const Outcome outcome = run_program(command);
    expect_refusal(outcome);
    EXPECT_TRUE(holds(outcome.err, "own.yaml:8: torque: column 17 of"));
    EXPECT_TRUE(holds(outcome.err, "unknown name 'peroid', did you mean 'period'?"));
  }
  expect_refusal(run_program({"simulate", kExperiment, "--augmented", file}));
}

TEST(UserEffect, ThatIsNotNamedIsSaidToHaveBeenTried) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("own.yaml", kCogging), data = folder / "trials";
  const std::string few = folder.write("s.yaml", "largest_model: 1\nkept_singles: 3\n");
  ASSERT_EQ(run_program({"simulate", kExperiment, "--effect",
                         "joint_viscous_friction:coefficient=0.1", "--out", data})
                .exit_code,
            0);
  const Outcome outcome = run_program(
      {"diagnose", data, "--settings", few, "--effects", file, "--out", folder / "out"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "note: my_cogging (own.yaml): tried and not named"))
      << outcome.out;
}

TEST(UserEffect, ThatNobodyAsksForIsRefused) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("own.yaml", kCogging);
  const Outcome outcome = run_program({"simulate", kExperiment, "--effects", file});
  expect_refusal(outcome);
  EXPECT_TRUE(holds(outcome.err, "no --effect names 'my_cogging'"));
}

}  // namespace
}  // namespace jaculus::cli
