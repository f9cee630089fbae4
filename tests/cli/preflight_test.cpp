// jaculus preflight as a user runs it, and what it refuses.

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
using test::TemporaryFolder;

TEST(PreflightCommand, SaysWhatAPendulumsSwingCouldTell) {
  const TemporaryFolder folder;
  const Outcome outcome = run_program(
      {"preflight", kProblems + "pendulum_trials.yaml", "--planned-only", "--out", folder / "out"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "would be named at some size within their bounds"));
  EXPECT_TRUE(holds(outcome.out, "not told apart (first at work / second at work"));

  std::ifstream stream(folder / "out/preflight.json");
  const json answer = json::parse(stream, nullptr, false);
  ASSERT_EQ(answer.at("format"), "jaculus-preflight/1");
  EXPECT_EQ(answer.at("possible"), true);
  EXPECT_EQ(answer.at("summary").size(), 3u);
  bool friction = false;
  for (const json& effect : answer.at("effects")) {
    if (effect.at("name") != "joint_coulomb_friction") continue;
    friction = true;
    EXPECT_EQ(effect.at("visible"), true);
    EXPECT_GT(effect.at("least").get<double>(), 0.0);
    EXPECT_LT(effect.at("least").get<double>(), 1.0);
    EXPECT_EQ(effect.at("unit"), "N m");
  }
  EXPECT_TRUE(friction);
  std::ifstream page(folder / "out/report.html");
  const std::string html((std::istreambuf_iterator<char>(page)), {});
  EXPECT_TRUE(holds(html, "Which could not be told apart"));
}

TEST(PreflightCommand, TakesAnEffectOfTheUsersOwn) {
  const TemporaryFolder folder;
  // Slopes are taken at a share of the scale, so that only of one scale they are the same.
  const std::string own =
      folder.write("catch.yaml",
                   "format: jaculus-effect/1\nname: my_catch\ncaption: constant pull\n"
                   "at: {joint: pendulum}\nexperiment: " +
                       kProblems +
                       "pendulum_trials.yaml\n"
                       "parameters:\n  pull: {unit: N m, nominal: 0, bounds: [-1, 1], scale: 0.3}\n"
                       "torque: \"pull\"\n");
  const Outcome outcome = run_program({"preflight", kProblems + "pendulum_trials.yaml",
                                       "--planned-only", "--effects", own, "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json answer = json::parse(outcome.out, nullptr, false);
  bool own_offset = false;
  for (const json& pair : answer.at("pairs"))
    if (pair.at("effects") == json::array({"joint_torque_offset", "my_catch"})) {
      own_offset = true;
      EXPECT_EQ(pair.at("structural"), true);  // a constant torque is the catalogue's offset
      EXPECT_EQ(pair.at("tellable"), false);
    }
  EXPECT_TRUE(own_offset);
}

TEST(PreflightCommand, EndsWithOneWhereDataCouldNotBeDiagnosed) {
  const Outcome outcome =
      run_program({"preflight", kProblems + "pendulum_trials.yaml", "--trials", "1"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(holds(outcome.out, "one trial")) << outcome.out;
}

TEST(PreflightCommand, RefusesWhatIsNoExperiment) {
  const Outcome missing = run_program({"preflight", "no_such.yaml"});
  expect_refusal(missing);
  EXPECT_TRUE(holds(missing.err, "there is no such file")) << missing.err;

  const TemporaryFolder folder;
  const std::string wrong = folder.write(
      "wrong.yaml",
      "format: jaculus-experiment/1\nname: wrong\nexperiment: pendulum\nrobot: ak80_pendulum\n"
      "input: {torque: {pendulum: [[0, 1 N m], [1 s, 0]]}}\ninitial: {pendulum: 0}\n"
      "controller: {kind: torque, rate_hz: 500}\nstreams:\n  joints: {rate_hz: fast}\n");
  const Outcome refused = run_program({"preflight", wrong});
  expect_refusal(refused);
  EXPECT_TRUE(holds(refused.err, "wrong.yaml:9: ")) << refused.err;
  EXPECT_TRUE(holds(refused.err, "rate_hz")) << refused.err;

  const Outcome size =
      run_program({"preflight", kProblems + "pendulum_trials.yaml", "--size", "0"});
  expect_refusal(size);
}

}  // namespace
}  // namespace jaculus::cli
