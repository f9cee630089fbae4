// Bad command lines, as a user meets them: exit code 2, nothing on standard output, one message
// that says what was given and what is allowed; and no output half-written.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "cli/bad_input.h"
#include "cli/program.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::cli {
namespace {

using test::BadInput;
using test::bytes_of;
using test::expect_refusal;
using test::holds;
using test::Outcome;
using test::run_program;

struct FlagCase {
  std::vector<std::string> arguments;
  const char* key;
  const char* allowed;
};

TEST_F(BadInput, EveryFaultOfTheCommandLineIsNamed) {
  const FlagCase cases[] = {
      {{}, "no command", "check"},
      {{"chek", "problem.yaml"}, "chek", "did you mean 'check'?"},
      {{"--chek"}, "--chek", "allowed"},
      {{"check"}, "no file given", "problem files"},
      {{"check", "--explian"}, "--explian", "did you mean '--explain'?"},
      {{"check", "none.yaml"}, "none.yaml", "not found"},
      {{"check", "nobody"}, "nobody", "unknown robot"},
      {{"check", "problem.yaml", "--colour"}, "--colour", "allowed"},
      {{"export"}, "solution", "--help"},
      {{"export", "plan.csv"}, "--as", "--help"},
      {{"export", "plan.csv", "--as", "cvs"}, "--as", "did you mean 'csv'?"},
      {{"export", "plan.csv", "--as", "csv"}, "plan.csv", "not found"},
      {{"export", "problem.yaml", "--as", "csv"}, "problem.yaml", "plan.csv"},
      {{"export", "plan.csv", "--as", "csv", "--rate", "0"}, "--rate", "1 to 1e+06 Hz"},
      {{"export", "plan.csv", "--as", "csv", "--rate", "1 kg"}, "--rate", "kg"},
      {{"export", "plan.csv", "--as", "csv", "--rate", "fast"}, "--rate", "fast"},
      {{"export", "plan.csv", "--as", "csv", "--side", "joints"},
       "--side",
       "did you mean 'joint'?"},
      {{"export", "plan.csv", "--as", "csv", "--hold", "zoh"}, "--hold", "held, linear"},
      {{"export", "plan.csv", "--as", "csv", "--json"}, "--json", "--out"},
      {{"export", "plan.csv", "--as", "csv", "--out", "toy"}, "--out toy", "a file"},
  };
  for (const FlagCase& c : cases) {
    std::string trace;
    for (const std::string& argument : c.arguments) trace += argument + " ";
    SCOPED_TRACE(trace);
    const Outcome outcome = run_program(c.arguments, folder.path());
    expect_refusal(outcome);
    EXPECT_TRUE(holds(outcome.err, c.key));
    EXPECT_TRUE(holds(outcome.err, c.allowed));
  }
}

TEST_F(BadInput, LeavesAnEarlierExportAsItWas) {
  folder.write("plan.csv", "time [s],swing [rad],swing_velocity [rad/s]\n0,0,0\n1,1,0\n");
  folder.write("out.csv", "earlier");
  expect_refusal(run_program(
      {"export", "plan.csv", "--as", "csv", "--hold", "held", "--out", "out.csv"}, folder.path()));
  EXPECT_EQ(bytes_of(folder / "out.csv"), "earlier");
}

TEST_F(BadInput, MakesNoFilesBesideAnOutputThatCantBeWritten) {
  folder.write(
      "plan.csv",
      "time [s],swing [rad],swing_velocity [rad/s],swing_torque [N m]\n0,0,0,1\n1,1,0,1\n");
  expect_refusal(run_program(
      {"export", "plan.csv", "--as", "csv", "--hold", "held", "--out", "no/such/folder/out.csv"},
      folder.path()));
  EXPECT_FALSE(std::filesystem::exists(folder / "no"));
}

TEST_F(BadInput, BagsAreReadByThePythonPackageAndTheProgramSaysSo) {
  for (const std::string kind : {"mcap", "bag", "parquet"}) {
    const Outcome outcome = run_program({"import", kind, "log", "--robot", "arm", "--out", "x"});
    expect_refusal(outcome);
    EXPECT_TRUE(holds(outcome.err, "import " + kind));
    EXPECT_TRUE(holds(outcome.err, "the command of the Python package"));
  }
}

}  // namespace
}  // namespace jaculus::cli
