// Bars with the remaining time appear on a terminal, and nowhere else.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cli/program.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::cli {
namespace {

using namespace test;

/// Standard error of a command on a terminal must show `shown`, elsewhere nothing of it, and with
/// --quiet nowhere anything.
void expect_on_terminals_only(const std::vector<std::string>& arguments,
                              const std::vector<std::string>& shown) {
  const Outcome terminal = run_on_terminal(arguments), file = run_program(arguments);
  EXPECT_EQ(terminal.exit_code, 0) << terminal.err;
  EXPECT_EQ(file.exit_code, 0) << file.err;
  for (const std::string& text : shown) EXPECT_TRUE(holds(terminal.err, text));
  EXPECT_TRUE(holds(terminal.err, "\r\x1b[K"));
  EXPECT_EQ(file.err.find_first_of("\r\x1b"), std::string::npos) << file.err;
  EXPECT_EQ(file.err.find("to go"), std::string::npos) << file.err;
  EXPECT_EQ(file.out.find_first_of("\r\x1b"), std::string::npos) << file.out;
  std::vector<std::string> quiet = arguments;
  quiet.emplace_back("--quiet");
  EXPECT_EQ(run_on_terminal(quiet).err, "");
}

TEST(Progress, SeveralStartsShowHowManyAreDoneAndTheTimeLeft) {
  expect_on_terminals_only({"solve", kProblems + "double_integrator.yaml", "--starts", "4"},
                           {"double_integrator, starts [", "] 1/4  ", "] 4/4  ", " to go"});
}

TEST(Progress, OneStartShowsItsIterations) {
  expect_on_terminals_only({"solve", kProblems + "double_integrator.yaml"},
                           {"double_integrator: iteration 0"});
}

TEST(Progress, SweepsShowTheirTasks) {
  expect_on_terminals_only({"study", kProblems + "self_righting.yaml"}, {"] 1/", " to go"});
}

TEST(Progress, DiagnosisShowsItsStage) {
  const TemporaryFolder folder;
  const Outcome made = run_program(
      {"simulate", kProblems + "pendulum_trials.yaml", "--trials", "2", "--out", folder / "data"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  expect_on_terminals_only(
      {"diagnose", folder / "data"},
      {"] screening  ", "] held-out gap and intervals  ", " s, ", " in all", " to go"});
}

TEST(Progress, LeavesTheTerminalToWhateverReadsJsonFromAPipe) {
  const std::vector<std::string> arguments = {"solve", kProblems + "double_integrator.yaml",
                                              "--json"};
  const Outcome piped = run_on_terminal(arguments, Output::pipe);
  EXPECT_EQ(piped.exit_code, 0) << piped.err;
  EXPECT_EQ(piped.err, "");
  EXPECT_TRUE(holds(piped.out, "\"status\": \"optimal\""));
  EXPECT_TRUE(holds(run_on_terminal(arguments).err, "iteration 0"));
}

}  // namespace
}  // namespace jaculus::cli
