// Commands end to end, through the program.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/program.h"
#include "jaculus/core/installation.h"
#include "jaculus/effects/effect.h"
#include "jaculus/solver/summary.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::cli {
namespace {

using test::bytes_of;
using test::holds;
using test::kProblems;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;

TEST(Command, EveryCommandHasHelpWithAnExample) {
  for (const char* command : {"check", "export", "study"}) {
    const Outcome outcome = run_program({command, "--help"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_TRUE(holds(outcome.out, "Example:"));
    EXPECT_TRUE(holds(outcome.out, std::string("jaculus ") + command));
  }
  EXPECT_EQ(run_program({"--help"}).exit_code, 0);
  EXPECT_EQ(run_program({"--version"}).out, std::string(version()) + "\n");
}

TEST(Command, CheckPrintsProblemsAndRobots) {
  const Outcome outcome = run_program({"check", kProblems + "leap_tail.yaml", "minitaur_tail"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "phase         rear_feet: rear_foot, 15 intervals"));
  EXPECT_TRUE(holds(outcome.out, "tail.drag.coefficient"));
  EXPECT_EQ(run_program({"check", "--quiet", kProblems + "leap_tail.yaml"}).out, "");
}

TEST(Command, CheckJsonIsNothingButJson) {
  const Outcome outcome = run_program({"check", "--json", kProblems + "leap_inactive.yaml"});
  const auto json = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(json.size(), 1u);
  EXPECT_EQ(json[0]["name"], "leap_inactive");
  EXPECT_NEAR(json[0]["lock"]["tail"].get<double>(), -1.5707963267948966, 1e-15);
  EXPECT_EQ(json[0]["limits"]["voltage"], 7.0);
  EXPECT_EQ(json[0]["phases"][0]["intervals"], 15);
}

TEST(Command, CheckExplainsEveryKey) {
  const Outcome outcome = run_program({"check", "--explain"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out.find(transcription::explain_problem()), 0u);
}

TEST(Command, SimulateExplainsEveryEffectWithItsParameters) {
  const Outcome outcome = run_program({"simulate", "--explain"});
  EXPECT_EQ(outcome.exit_code, 0);
  for (const effects::Effect& effect : effects::effect_catalogue()) {
    const std::size_t at = outcome.out.find("\n" + effect.name + ": " + effect.caption + "\n");
    ASSERT_NE(at, std::string::npos) << effect.name;
    for (const effects::EffectParameter& parameter : effect.parameters)
      EXPECT_NE(outcome.out.find("\n  " + parameter.name, at), std::string::npos) << effect.name;
  }
}

class ExportCommand : public ::testing::Test {
 protected:
  ExportCommand() {
    folder.write("plan.csv",
                 "time [s],arm [rad],arm_velocity [rad/s],arm_torque [N "
                 "m],phase\n0,0,0,1,a\n0.1,0.1,1,2,a\n0.1,0.1,1,-1,b\n"
                 "0.2,0.2,1,-1,b\n");
    summary.name = "toy";
    summary.status = solver::Status::optimal;
    summary.verification.passed = true;
    summary.input_hold = transcription::InputHold::held;
    solver::MotorFigures motor;
    motor.joint = "arm";
    motor.torque_limit = 3.0;
    motor.torque_constant = 0.1;
    motor.resistance = 0.2;
    motor.saturation_linear = 9.0;
    motor.saturation_cubic = 0.0;
    summary.motors = {motor};
    save();
  }
  void save() const { folder.write("summary.json", solver::to_json(summary).dump()); }
  TemporaryFolder folder;
  solver::Summary summary;
};

TEST_F(ExportCommand, WritesEveryFormatToFileAndToStandardOutput) {
  for (const char* format : {"csv", "json", "joint_trajectory", "c"}) {
    SCOPED_TRACE(format);
    const Outcome file = run_program(
        {"export", folder.path(), "--as", format, "--rate", "100 Hz", "--out", folder / "out"});
    EXPECT_EQ(file.exit_code, 0) << file.err;
    const Outcome stream = run_program({"export", folder.path(), "--as", format, "--rate", "100"});
    EXPECT_EQ(stream.exit_code, 0);
    EXPECT_EQ(stream.out, bytes_of(folder / "out"));
    EXPECT_GT(stream.out.size(), 100u);
  }
}

TEST_F(ExportCommand, ExceededLimitIsWrittenAndSaid) {
  summary.motors[0].torque_limit = 0.9;
  save();
  const Outcome outcome =
      run_program({"export", folder.path(), "--as", "c", "--json", "--out", folder / "plan.h"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(holds(outcome.err, "limit exceeded"));
  EXPECT_TRUE(holds(bytes_of(folder / "plan.h"), "LIMIT EXCEEDED: arm torque 1 N m of 0.9"));
  EXPECT_TRUE(nlohmann::json::parse(outcome.out)["limits"][0]["exceeded"].get<bool>());
}

TEST_F(ExportCommand, AnUnsolvedPlanMustBeAskedFor) {
  summary.status = solver::Status::infeasible;
  save();
  const Outcome refused =
      run_program({"export", folder.path(), "--as", "csv", "--out", folder / "out"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_TRUE(holds(refused.err, "--even-unsolved"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  EXPECT_EQ(run_program({"export", folder.path(), "--as", "csv", "--even-unsolved"}).exit_code, 1);
}

}  // namespace
}  // namespace jaculus::cli
