#include "jaculus/trajectory/dataset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "support/input_error.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace jaculus::trajectory {
namespace {

using test::bytes_of;
using test::holds;
using test::input_error_of;
using test::TemporaryFolder;

constexpr const char* kYaml = R"(format: jaculus-dataset/1
experiment: leap
robot: minitaur
override: {motors.front_a.resistance: 0.2 ohm, friction: 0.7}
plan: plan.csv
initial: {pitch: 5 deg, z: 20 cm}
stops: {tail: {range: [-90 deg, .inf], restitution: 0.3}}
controller: {kind: feedforward_pd, quantity: duty, rate_hz: 1 kHz, kp: {front_a: 0.4, "*": )"
                              R"(unknown}, kd: [0.01, 0.02], bus_voltage: 16 V}
streams:
  mocap: {file: mocap.csv, rate_hz: 240}
  joints: {file: joints.csv}
trials: [trial_01, trial_02]
provenance: "made up: for a test"
)";
constexpr const char* kPlan =
    "phase,time [ms],x [m]\npush,0,0\npush,100,0.1\nfly,100,0.1\nfly,200,0.2\n";
constexpr const char* kMocap = "time [ms],x [mm],pitch [deg]\n0,0,\n10,1,90\n20,,\n";
constexpr const char* kJoints =
    "time [s],front_a [rad],front_a_duty [-],bus_voltage [V]\n0.001,1,0.5,16\n";

/// A dataset's folder with one thing put wrong.
struct Sample {
  Sample() {
    for (const char* trial : {"trial_01", "trial_02"})
      std::filesystem::create_directories(folder / trial);
    folder.write("dataset.yaml", kYaml);
    folder.write("plan.csv", kPlan);
    folder.write("trial_01/mocap.csv", kMocap);
    folder.write("trial_01/joints.csv", kJoints);
    folder.write("trial_02/mocap.csv", "time [s],x [m],pitch [rad]\n0,0,0\n0.5,1,1\n");
  }
  void replace(const std::string& what, const std::string& by) const {
    std::string text = kYaml;
    const auto at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    folder.write("dataset.yaml", text.replace(at, what.size(), by));
  }
  [[nodiscard]] std::string fault() const {
    return input_error_of([this] { (void)read_dataset(folder.path()); });
  }
  TemporaryFolder folder;
};

TEST(Dataset, ReadsStreamsInSiWithGapsAndTrialsOfDifferentLengths) {
  const Sample sample;
  const Dataset dataset = read_dataset(sample.folder.path());
  EXPECT_EQ(dataset.experiment, ExperimentKind::leap);
  EXPECT_EQ(dataset.overrides.at("motors.front_a.resistance"), "0.2 ohm");
  EXPECT_NEAR(dataset.initial.at("pitch"), 5.0 * 3.14159265358979 / 180.0, 1e-12);
  EXPECT_NEAR(dataset.initial.at("z"), 0.2, 1e-15);
  ASSERT_TRUE(dataset.plan);
  EXPECT_NEAR(dataset.plan->values(3, dataset.plan->column("time")), 0.2, 1e-15);
  EXPECT_EQ(dataset.controller.quantity, Quantity::duty);
  EXPECT_TRUE(dataset.controller.gains_stated);
  EXPECT_EQ(dataset.controller.kp.at("front_a").range.lower, 0.4);
  EXPECT_FALSE(dataset.controller.kp.at("*").known());
  EXPECT_EQ(dataset.controller.kd.at("*").range.upper, 0.02);
  ASSERT_EQ(dataset.trials.size(), 2u);
  const Stream* mocap = dataset.trials[0].stream("mocap");
  ASSERT_NE(mocap, nullptr);
  EXPECT_EQ(mocap->rate_hz, 240.0);
  EXPECT_EQ(mocap->units, (std::vector<std::string>{"m", "rad"}));
  EXPECT_NEAR(mocap->time[1], 0.01, 1e-15);
  EXPECT_NEAR(mocap->values(0, 1), 1e-3, 1e-15);
  EXPECT_NEAR(mocap->values(1, 1), 3.14159265358979 / 2.0, 1e-12);
  EXPECT_TRUE(std::isnan(mocap->values(1, 0)));
  EXPECT_TRUE(std::isnan(dataset.trials[0].stream("joints")->rate_hz));
  EXPECT_EQ(dataset.trials[1].stream("joints"), nullptr);
  ASSERT_EQ(dataset.notes.size(), 1u);
  EXPECT_EQ(dataset.notes[0], "trial_02 has no joints.csv");
}

TEST(Dataset, ReadsBackWhatItWrote) {
  const Sample sample;
  Dataset dataset = read_dataset(sample.folder.path());
  write_dataset(dataset, sample.folder / "copy");
  EXPECT_EQ(dataset.folder, sample.folder / "copy");
  Dataset copy = read_dataset(sample.folder / "copy");
  EXPECT_EQ(copy.provenance, dataset.provenance);
  EXPECT_EQ(copy.overrides, dataset.overrides);
  EXPECT_EQ(copy.initial, dataset.initial);
  EXPECT_EQ(copy.stops.at("tail").range.lower, dataset.stops.at("tail").range.lower);
  EXPECT_EQ(copy.stops.at("tail").restitution, 0.3);
  EXPECT_EQ(copy.plan->values, dataset.plan->values);
  EXPECT_EQ(copy.trials[1].streams[0].values, dataset.trials[1].streams[0].values);
  write_dataset(copy, sample.folder / "again");
  for (const char* file : {"dataset.yaml", "plan.csv", "trial_01/mocap.csv", "trial_01/joints.csv"})
    EXPECT_EQ(bytes_of(sample.folder / "copy" / file), bytes_of(sample.folder / "again" / file))
        << file;
}

TEST(Dataset, ReadsScriptsFromStepsAndFromAFile) {
  const Sample sample;
  sample.folder.write("input.csv",
                      "time [s],tail_voltage [V],rear_a_voltage [V]\n0,12,0\n0.1,0,3\n");
  const std::string old = "plan: plan.csv";
  sample.replace(old, "input: {quantity: voltage, file: input.csv}");
  Dataset dataset = read_dataset(sample.folder.path());
  ASSERT_TRUE(dataset.script);
  EXPECT_EQ(dataset.script->joints, (std::vector<std::string>{"tail", "rear_a"}));
  EXPECT_EQ(dataset.script->values(1, 1), 3.0);
  const Matrix from_file = dataset.script->values;
  sample.replace(old, "input: {voltage: {tail: [[0, 12 V], [100 ms, 0 V]], rear_a: [[0.1, 3]]}}");
  dataset = read_dataset(sample.folder.path());
  EXPECT_EQ(dataset.script->values, from_file);
  write_dataset(dataset, sample.folder / "copy");
  EXPECT_EQ(read_dataset(sample.folder / "copy").script->values, from_file);
}

TEST(Dataset, SaysWhereItsFilesAreWrong) {
  struct Case {
    std::string file, text, message;
  };
  const std::vector<Case> cases = {
      {"trial_01/mocap.csv", "time [s],x [m]\n0,1\n0.2,2\n0.1,3\n",
       "mocap.csv:4: time: 0.1 s follows 0.2 s"},
      {"trial_01/mocap.csv", "time [s],x [m]\n0,1\n0.2,2\n0.2,3\n",
       "mocap.csv:4: time: 0.2 s stands twice"},
      {"trial_01/mocap.csv", "time [s],x [m]\n0,1\n,2\n", "mocap.csv:3: time: an empty cell"},
      {"trial_01/mocap.csv", "", "mocap.csv: the file is empty"},
      {"trial_01/mocap.csv", "time [s],x [m]\n", "mocap.csv:1: there is a header but no row"},
      {"trial_01/mocap.csv", "time [s],x [m]\n0,1\n0.1",
       "mocap.csv:3: the row has 1 cell; the header has 2"},
      {"trial_01/mocap.csv", "time [s],x [m]\n0,nan\n",
       "mocap.csv:2: column 'x': 'nan' is not a number"},
      {"trial_01/mocap.csv", "time [s],x\n0,1\n",
       "mocap.csv:1: column 'x' has no unit; allowed: 'x [m]'"},
      {"trial_01/mocap.csv", "time,x [m]\n0,1\n", "mocap.csv:1: column 'time' has no unit"},
      {"trial_01/mocap.csv", "time [s],pitch [m]\n0,1\n",
       "mocap.csv:1: column 'pitch [m]': allowed: a unit such as '[rad]'"},
      {"trial_01/mocap.csv", "time [s]\n0\n", "mocap.csv:1: there is no column but time"},
      {"trial_01/mocap.csv", "time [s],x [m]\n3,1\n",
       "mocap.csv:2: time: the stream begins at 3 s, after the plan's end at 0.2 s"},
      {"trial_01/joints.csv", "time [s],front_a\n0,1\n",
       "joints.csv:1: column 'front_a' has no unit; allowed: 'front_a [rad]'"},
      {"plan.csv", "time [s],x [m]\n0,0\n0.2,0\n0.1,0\n", "plan.csv:4: time: 0.1 s follows 0.2 s"},
      {"plan.csv", "time [s],x [m]\n0,0\n", "plan.csv:2: the plan ends where it begins"},
  };
  for (const Case& c : cases) {
    const Sample sample;
    sample.folder.write(c.file, c.text);
    EXPECT_TRUE(holds(sample.fault(), c.message)) << c.text;
  }
}

TEST(Dataset, SaysWhereItsDescriptionIsWrong) {
  struct Case {
    std::string what, by, message;
  };
  const std::vector<Case> cases = {
      {"rate_hz: 1 kHz", "rate_hz: 0", "dataset.yaml:8: controller.rate_hz: 0 is out of range"},
      {"experiment: leap", "experiment: lep",
       "dataset.yaml:2: experiment: 'lep' given, did you mean 'leap'?"},
      {"mocap.csv, rate_hz", "mocp.csv, rate_hz",
       "dataset.yaml:10: streams.mocap.file: no trial has a file mocp.csv"},
      {"mocap.csv, rate_hz", "../mocap.csv, rate_hz", "allowed: a file in the trials' folders"},
      {"trial_01, trial_02", "trial_01, trial_03",
       "dataset.yaml:12: trials[1]: there is no folder"},
      {"trial_01, trial_02", "trial_01, trial_01",
       "dataset.yaml:12: trials[1]: 'trial_01' stands twice"},
      {"plan: plan.csv", "plan: plann.csv", "dataset.yaml:5: plan: there is no file"},
      {"plan: plan.csv\n", "",
       "key 'plan' is missing; a controller of kind feedforward_pd needs plan or input"},
      {"kind: feedforward_pd", "kind: pid",
       "controller.kind: 'pid' given; allowed: feedforward_pd"},
      {"kp: {front_a: 0.4", "kp: {front_a: -0.4", "controller.kp.front_a: -0.4 is out of range"},
      {"kp: {front_a: 0.4", "kp: {front_a: 0.4 N m/rad", "controller.kp.front_a"},
      {"kd: [0.01, 0.02]", "kd: [0.02, 0.01]", "lower bound 0.02 is above upper bound 0.01"},
      {"bus_voltage", "bus_volts", "unknown key 'bus_volts', did you mean 'bus_voltage'?"},
      {"robot: minitaur\n", "", "key 'robot' is missing"},
  };
  for (const Case& c : cases) {
    const Sample sample;
    sample.replace(c.what, c.by);
    EXPECT_TRUE(holds(sample.fault(), c.message)) << c.by;
  }
  EXPECT_TRUE(holds(input_error_of([] { (void)read_dataset("nowhere/at/all"); }),
                    "there is no such folder"));
  const TemporaryFolder empty;
  EXPECT_TRUE(
      holds(input_error_of([&] { (void)read_dataset(empty.path()); }), "no dataset.yaml here"));
}

TEST(Dataset, TheRealOnesLoadAsTheyAre) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  int loaded = 0;
  for (const auto& entry : std::filesystem::directory_iterator(data / "minitaur")) {
    if (!entry.is_directory()) continue;
    const Dataset dataset = read_dataset(entry.path());
    // The joint logs state no controller. The leaps' commands are duties of some 15.5 V; the gains
    // of these days are known as ranges alone.
    const bool stated = !entry.path().filename().string().starts_with("leap_joints");
    EXPECT_EQ(dataset.controller.quantity_stated, stated) << entry.path();
    EXPECT_EQ(dataset.controller.bus_voltage.has_value(), stated) << entry.path();
    if (stated) {
      EXPECT_FALSE(dataset.controller.kp.at("*").known()) << entry.path();
    }
    ASSERT_TRUE(dataset.plan);
    EXPECT_GE(dataset.plan->column("front_a_duty"), 0);
    for (const Trial& trial : dataset.trials) ASSERT_EQ(trial.streams.size(), 1u);
    ++loaded;
  }
  EXPECT_EQ(loaded, 7);
  const Dataset pendulum = read_dataset(data / "pendulum" / "ak80");
  EXPECT_EQ(pendulum.controller.kind, ControllerKind::measured);
  EXPECT_EQ(pendulum.controller.input, Quantity::torque);
  ASSERT_EQ(pendulum.trials.size(), 2u);
  EXPECT_EQ(pendulum.trials[0].streams[0].units, (std::vector<std::string>{"rad", "rad/s", "N m"}));
  EXPECT_GT(pendulum.trials[0].streams[0].time.size(), 2000);
}

}  // namespace
}  // namespace jaculus::trajectory
