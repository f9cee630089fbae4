// Experiments, imports and datasets through the program, and what it says of bad ones.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "cli/program.h"
#include "jaculus/trajectory/dataset.h"
#include "support/input_error.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::bytes_of;
using test::holds;
using test::kProblems;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;

TEST(TestbedRun, LogsTheTorqueThatDroveASwing) {
  const TemporaryFolder folder;
  const Outcome run = run_program({"testbed", "run", "swing", "--robot", "pendulum", "--input",
                                   "logged_torque", "--trials", "2", "--out", folder / "swing"});
  if (holds(run.err, "without MuJoCo")) GTEST_SKIP() << "no MuJoCo";
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const trajectory::Dataset dataset = trajectory::read_dataset(folder / "swing");
  EXPECT_EQ(dataset.controller.kind, trajectory::ControllerKind::measured);
  EXPECT_GE(dataset.trials[0].stream("joints")->channel("swing_torque"), 0);
  EXPECT_EQ(run_program({"check", folder / "swing"}).exit_code, 0);
}

TEST(Simulate, LeapTrialsGiveADatasetThatReadsBackAndTheSameBytesForASeed) {
  const TemporaryFolder folder;
  const auto simulate = [&](const std::string& name, const std::string& seed) {
    return run_program({"simulate", kProblems + "leap_trials.yaml", "--trials", "2", "--seed", seed,
                        "--out", folder / name});
  };
  const Outcome outcome = simulate("a", "7");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  ASSERT_EQ(simulate("b", "7").exit_code, 0);
  ASSERT_EQ(simulate("c", "8").exit_code, 0);
  for (const char* file :
       {"dataset.yaml", "plan.csv", "trial_01/mocap.csv", "trial_02/joints.csv", "summary.json"})
    EXPECT_EQ(bytes_of(folder / "a" / file), bytes_of(folder / "b" / file)) << file;
  EXPECT_NE(bytes_of(folder / "a" / "trial_01/mocap.csv"),
            bytes_of(folder / "c" / "trial_01/mocap.csv"));
  EXPECT_NE(bytes_of(folder / "a" / "trial_01/mocap.csv"),
            bytes_of(folder / "a" / "trial_02/mocap.csv"));

  const trajectory::Dataset dataset = trajectory::read_dataset(folder / "a");
  EXPECT_EQ(dataset.robot, "minitaur_tail");
  ASSERT_EQ(dataset.trials.size(), 2u);
  const trajectory::Stream* mocap = dataset.trials[0].stream("mocap");
  ASSERT_NE(mocap, nullptr);
  EXPECT_EQ(mocap->rate_hz, 240.0);
  EXPECT_NEAR(mocap->time[0], -0.3, 1e-9);
  // At rest before the command: what is left is the noise of 0.3 mm.
  const int x = mocap->channel("x");
  double sum = 0.0;
  for (int k = 0; k < 60; ++k)
    sum += std::isnan(mocap->values(x, k)) ? 0.0 : std::pow(mocap->values(x, k), 2);
  EXPECT_NEAR(std::sqrt(sum / 60.0), 3e-4, 1e-4);

  const json summary = json::parse(bytes_of(folder / "a" / "summary.json"));
  const json& leap = summary["trials"][0]["leap"];
  // The plan's own v/T is 6.77; the scattered pose and the sampled loop leave it nearly there.
  EXPECT_NEAR(leap["plan_end"]["acceleration_m_s2"].get<double>(), 6.77, 0.05);
  EXPECT_NEAR(leap["lift_off"]["time_s"].get<double>(), 0.192, 0.005);
  EXPECT_TRUE(leap["recipe_without_noise"]["bias_m_s2"].is_number());
  EXPECT_TRUE(holds(outcome.out, "recipe"));
}

TEST(Simulate, EffectsChangeTheRunAndPerturbReportsMargins) {
  const auto run = [](const std::vector<std::string>& extra) {
    std::vector<std::string> arguments = {"simulate", kProblems + "leap_trials.yaml", "--trials",
                                          "1", "--json"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    const Outcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(outcome.out);
  };
  const json plain = run({"--perturb", "8"});
  const json soft = run({"--effect", "tail_compliance:stiffness=60"});
  EXPECT_GT(std::abs(plain["trials"][0]["final"]["pitch"].get<double>() -
                     soft["trials"][0]["final"]["pitch"].get<double>()),
            1e-3);
  const json& margins = plain["perturb"]["margins"];
  for (const char* key :
       {"friction_share", "voltage_share", "torque_share", "current_share", "landing_pitch_rad"}) {
    EXPECT_LE(margins[key]["least"].get<double>(), margins[key]["median"].get<double>()) << key;
    EXPECT_LE(margins[key]["median"].get<double>(), margins[key]["largest"].get<double>()) << key;
  }
  EXPECT_LT(margins["voltage_share"]["least"].get<double>(),
            margins["voltage_share"]["largest"].get<double>());
}

TEST(Simulate, DropBenchAndPendulumRun) {
  for (const char* name : {"drop", "bench", "pendulum"}) {
    const TemporaryFolder folder;
    const Outcome outcome = run_program({"simulate", kProblems + name + "_trials.yaml", "--trials",
                                         "1", "--quiet", "--out", folder / "out"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(trajectory::read_dataset(folder / "out").trials.size(), 1u);
    EXPECT_EQ(run_program({"check", folder / "out"}).exit_code, 0) << name;
  }
}

TEST(Simulate, TheRecipesBiasShowsOnAPerfectRunOfTheAuthorsPlan) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Outcome outcome = run_program({"simulate", data / "plans" / "notail_V7.csv", "--robot",
                                       "minitaur", "--trials", "1", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json leap = json::parse(outcome.out)["trials"][0]["leap"];
  EXPECT_NEAR(leap["plan_end"]["acceleration_m_s2"].get<double>(), 5.94, 0.1);
  const double exact = leap["recipe_without_noise"]["bias_m_s2"].get<double>();
  const double noisy = leap["recipe"]["bias_m_s2"].get<double>();
  EXPECT_LT(std::abs(exact), 0.2);
  EXPECT_NE(exact, noisy) << "the start rule is at the mercy of the noise";
}

TEST(Check, PrintsTheRecipesAccelerationOfRealTrialsBesideThePlans) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const Outcome outcome = run_program(
      {"check", data / "minitaur" / "leap_tail_2019-06-21", data / "pendulum" / "ak80", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json checked = json::parse(outcome.out);
  EXPECT_NEAR(checked[0]["recipe"]["mean_m_s2"].get<double>(), 6.45, 0.05);
  EXPECT_NEAR(checked[0]["recipe"]["plan_m_s2"].get<double>(), 6.83, 0.01);
  EXPECT_TRUE(holds(checked[1]["robot_notes"].dump(), "the base is taken as fixed"));
}

// Bad input
// -------------------------------------------------------------------------------------------------

constexpr const char* kDataset = R"(format: jaculus-dataset/1
experiment: leap
robot: minitaur
plan: plan.csv
controller: {kind: feedforward_pd, rate_hz: 1000}
streams: {mocap: {file: mocap.csv, rate_hz: 10}}
trials: [trial_01, trial_02]
provenance: made up
)";

/// A sound dataset of two trials of different lengths.
struct Sample {
  Sample() {
    fs::create_directories(folder / "trial_01");
    fs::create_directories(folder / "trial_02");
    folder.write("dataset.yaml", kDataset);
    std::string plan = "time [s]", rows[2] = {"0", "0.2"};
    for (const char* joint : {"front_a", "front_b", "rear_a", "rear_b"}) {
      plan += fmt::format(",{0} [rad],{0}_velocity [rad/s],{0}_torque [N m]", joint);
      for (std::string& row : rows) row += ",1,0,0.1";
    }
    folder.write("plan.csv", plan + "\n" + rows[0] + "\n" + rows[1] + "\n");
    folder.write("trial_01/mocap.csv", "time [s],x [m]\n0,0\n0.1,1\n0.2,\n");
    folder.write("trial_02/mocap.csv", "time [s],x [m]\n0,0\n0.1,1\n");
  }
  void replace(const std::string& file, const std::string& what, const std::string& by) const {
    std::string text = bytes_of(folder / file);
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    folder.write(file, text.replace(at, what.size(), by));
  }
  TemporaryFolder folder;
};

TEST(BadDatasets, EndWithExitCodeTwoAndThePlace) {
  {
    const Sample sample;
    const Outcome outcome = run_program({"check", sample.folder.path()});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  struct Case {
    std::string file, what, by, message;
  };
  const std::vector<Case> cases = {
      {"dataset.yaml", "robot: minitaur", "robot: minitaur_tail",
       "plan.csv:1: column 'tail'"},  // a plan for another robot
      {"dataset.yaml", "robot: minitaur", "robot: nowhere/robot", "unknown robot 'nowhere/robot'"},
      {"dataset.yaml", "rate_hz: 1000", "rate_hz: 0",
       "dataset.yaml:5: controller.rate_hz: 0 is out of range"},
      // a joint is missing
      {"plan.csv", "rear_b [rad]", "rear_c [rad]", "plan.csv:1: column 'rear_b'"},
      {"plan.csv", "time [s]", "time", "plan.csv:1: column 'time' has no unit"},
      {"plan.csv", "\n0.2,1", "\n0.2,", "plan.csv:3: column 'front_a': a gap"},
      {"plan.csv", "\n0.2,", "\n-0.2,", "plan.csv:3: time: -0.2 s follows 0 s"},
      {"trial_01/mocap.csv", "\n0.1,1", "\n-0.1,1", "mocap.csv:3: time: -0.1 s follows 0 s"},
      {"trial_01/mocap.csv", "\n0.1,1", "\n0,1", "mocap.csv:3: time: 0 s stands twice"},
      {"trial_01/mocap.csv", "\n0.1,1", "\n0.1,nan",
       "mocap.csv:3: column 'x': 'nan' is not a number"},
      {"trial_01/mocap.csv", "\n0.2,", "\n0.2", "mocap.csv:4: the row has 1 cell"},
      {"trial_01/mocap.csv", "x [m]", "x", "mocap.csv:1: column 'x' has no unit"},
      {"trial_01/mocap.csv", "\n0,0\n0.1,1\n0.2,", "\n7,0\n8,0",
       "mocap.csv:2: time: the stream begins at 7 s, after the plan's end"},
      {"trial_01/mocap.csv", "time [s],x [m]\n0,0\n0.1,1\n0.2,\n", "",
       "mocap.csv: the file is empty"},
  };
  for (const Case& c : cases) {
    const Sample sample;
    sample.replace(c.file, c.what, c.by);
    const Outcome outcome = run_program({"check", sample.folder.path()});
    EXPECT_EQ(outcome.exit_code, 2) << c.by;
    EXPECT_TRUE(outcome.out.empty()) << outcome.out;
    EXPECT_TRUE(holds(outcome.err, c.message));
  }
}

TEST(BadExperiments, EndWithExitCodeTwoAndThePlace) {
  struct Case {
    std::string what, by, message;
  };
  const std::vector<Case> cases = {
      {"rate_hz: 1 kHz\n  kp", "rate_hz: 0\n  kp", "controller.rate_hz: 0 is out of range"},
      {"robot: minitaur_tail", "robot: minitaur_tale",
       "unknown robot 'minitaur_tale', did you mean 'minitaur_tail'?"},
      {"plan: leap_tail_plan.csv", "plan: no_plan.csv", "plan: there is no file"},
      {"[x, z, pitch]", "[x, z, pich]", "'pich' given, did you mean 'pitch'?"},
      {"rate_hz: 240", "rate_hz: 0", "streams.mocap.rate_hz: 0 is out of range"},
      {"x: 0.3 mm", "x: 0.3 deg", "streams.mocap.noise.x"},
      {"tail: 0.5 deg", "tial: 0.5 deg", "unknown key 'tial', did you mean 'tail'?"},
      {"dropout: 0.01", "dropout: 1.5", "streams.mocap.dropout: 1.5 is out of range"},
      {"kp: {\"*\": 3.3, tail: 8}", "kp: {\"*\": unknown}",
       "kp.*: unknown or a range; a simulation needs a number"},
      {"trials: 6", "trials: 0", "trials: 0 is out of range"},
      {"bodies.base.mass", "bodies.bass.mass",
       "uncertainties: 'bodies.bass.mass' is no model value"},
  };
  for (const Case& c : cases) {
    const TemporaryFolder folder;
    std::string text = bytes_of(kProblems + "leap_trials.yaml");
    const std::size_t at = text.find(c.what);
    ASSERT_NE(at, std::string::npos) << c.what;
    folder.write("e.yaml", text.replace(at, c.what.size(), c.by));
    folder.write("leap_tail_plan.csv", bytes_of(kProblems + "leap_tail_plan.csv"));
    const Outcome outcome =
        run_program({"simulate", folder / "e.yaml", "--trials", "1", "--perturb", "1"});
    EXPECT_EQ(outcome.exit_code, 2) << c.by;
    EXPECT_TRUE(holds(outcome.err, c.message));
  }
  const std::string leap = kProblems + "leap_trials.yaml";
  const std::vector<std::pair<std::vector<std::string>, std::string>> flags = {
      {{"nowhere.yaml"}, "nowhere.yaml: there is no such file"},
      {{kProblems + "leap_tail_plan.csv"}, "a plan needs --robot"},
      {{kProblems + "leap_tail_plan.csv", "--robot", "ak80_pendulum"},
       "leap_tail_plan.csv:1: column 'pendulum'"},
      {{leap, "--robot", "minitaur"}, "--robot: given for an experiment"},
      {{leap, "--effect", "tail_complance:stiffness=9"},
       "unknown effect 'tail_complance', did you mean 'tail_compliance'?"},
      {{kProblems + "bench_trials.yaml", "--perturb", "3"},
       "--perturb: bench_trials states no uncertainties"},
  };
  for (const auto& [extra, message] : flags) {
    std::vector<std::string> arguments = {"simulate"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    const Outcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_TRUE(holds(outcome.err, message));
  }
}

TEST(Import, MotionCaptureGoesThroughAndSaysWhatItAssumed) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  // A real trial as Motive would export it: Y up, forward along z, millimetres, Euler angles.
  const fs::path real = data / "minitaur" / "leap_tail_2019-06-21";
  const trajectory::Dataset source = trajectory::read_dataset(real);
  const trajectory::Stream& mocap = *source.trials[0].stream("mocap");
  std::string text =
      "Format Version,1.23,Export Frame Rate,120,Rotation Type,YXZ,Length "
      "Units,Millimeters,Coordinate Space,Global\n\n"
      ",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid "
      "Body\n,Name,Robot,Robot,Robot,Robot,Robot,Robot\n"
      ",,Rotation,Rotation,Rotation,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z,X,Y,Z\n";
  for (Eigen::Index k = 0; k < mocap.time.size(); ++k) {
    const auto value = [&](const char* channel) { return mocap.values(mocap.channel(channel), k); };
    // World x, y, z is the file's z, x, y; pitch turns about the file's x.
    text += fmt::format("{},{},{},0,0,{},{},{}\n", k, mocap.time[k] + 5.0,
                        value("pitch") * 57.29577951308232, 1e3 * value("y"), 1e3 * value("z"),
                        1e3 * value("x"));
  }
  const TemporaryFolder folder;
  const fs::path take = folder.write("take.csv", text);
  const Outcome outcome =
      run_program({"import", "optitrack", take, "--robot", "minitaur_tail", "--plan",
                   real / "plan.csv", "--cut=-0.3,1", "--out", folder / "out"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* assumed : {"y is taken as up", "forward is taken as +z of the file",
                              "YXZ in degrees", "start rule", "gains"})
    EXPECT_TRUE(holds(outcome.out, assumed));
  const trajectory::Dataset imported = trajectory::read_dataset(folder / "out");
  const trajectory::Stream& back = *imported.trials[0].stream("mocap");
  const double shift = mocap.time[0] - back.time[0];
  EXPECT_LT(std::abs(shift), 0.02) << "the start rule agrees with the one that cut the data";
  for (Eigen::Index k = 0; k < std::min(back.time.size(), mocap.time.size()); ++k) {
    EXPECT_NEAR(back.values(back.channel("z"), k), mocap.values(mocap.channel("z"), k), 0.05);
    if (std::abs(shift) > 1e-3) continue;
    EXPECT_NEAR(back.values(back.channel("x"), k), mocap.values(mocap.channel("x"), k), 1e-3);
    EXPECT_NEAR(back.values(back.channel("pitch"), k), mocap.values(mocap.channel("pitch"), k),
                2e-3);
  }
}

TEST(Import, BadFlagsEndWithExitCodeTwo) {
  const TemporaryFolder folder;
  const fs::path log = folder.write("log.csv", "t,q\n0,1\n1,2\n");
  const fs::path map = folder.write("map.yaml",
                                    "{format: jaculus-columns/1, channels: {time: {column: t, "
                                    "unit: s}, pendulum: {column: q, unit: "
                                    "rad}}}");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"csv", log, "--map", map, "--robot", "ak80_pendulum", "--out", folder / "o"},
       "neither --plan nor --controller is given"},
      {{"csv", log, "--map", map, "--robot", "nobody", "--controller",
        "{kind: measured, input: torque}", "--out", folder / "o"},
       "unknown robot 'nobody'"},
      {{"csv", log, "--map", map, "--robot", "ak80_pendulum", "--controller",
        "{kind: measured, input: torque}", "--cut", "1,0", "--out", folder / "o"},
       "--cut: '1,0' given"},
      {{"csv", log, "--map", map, "--robot", "ak80_pendulum", "--controller",
        "{kind: measured, input: torque}", "--start", "pendlum>1", "--out", folder / "o"},
       "--start: there is no channel 'pendlum', did you mean 'pendulum'?"},
      {{"optitrack", log, "--robot", "minitaur", "--controller", "{kind: measured, input: torque}",
        "--out", folder / "o"},
       "log.csv:1: 't' begins the line"},
      {{"openlog", log, "--format", map, "--robot", "minitaur", "--controller",
        "{kind: measured, input: torque}", "--out", folder / "o"},
       "map.yaml:1"},
  };
  for (const auto& [extra, message] : cases) {
    std::vector<std::string> arguments = {"import"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    const Outcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_TRUE(holds(outcome.err, message));
    EXPECT_FALSE(fs::exists(folder / "o" / "dataset.yaml"));
  }
}

}  // namespace
}  // namespace jaculus::cli
