// `jaculus check` of experiments, problems, effects: what the run refuses is refused, what is
// unusual told.

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "cli/program.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::cli {
namespace {

using test::bytes_of;
using test::expect_refusal;
using test::holds;
using test::kProblems;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;

/// A shipped experiment with one piece of text for another.
std::string experiment(const TemporaryFolder& folder, const std::string& name,
                       const std::string& what, const std::string& by) {
  std::string text = bytes_of(kProblems + name);
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return folder.write("e.yaml", text.replace(at, what.size(), by));
}

TEST(Check, RefusesAnExperimentThatNoRunCouldStart) {
  const TemporaryFolder folder;
  struct Case {
    const char *what, *by, *message;
  };
  for (const Case& c : {
           Case{"initial: {pendulum: 0}\n", "",
                "e.yaml:2: initial: the pose leaves 'pendulum' open; allowed: a value of every "
                "coordinate, {pendulum: VALUE}"},
           {"initial: {pendulum: 0}", "initial: {pendlum: 0}",
            "e.yaml:7: initial: 'pendlum' is no coordinate or joint of the robot, did you mean "
            "'pendulum'?"},
           {"duration: 3 s", "duration: 3 s\nuncertainties: {bodies.bop.mass: 3 %}",
            "e.yaml:10: uncertainties: 'bodies.bop.mass' is no model value of ak80_pendulum"},
           {"controller: {kind: torque, rate_hz: 500}",
            "controller: {kind: feedforward_pd, quantity: torque, kp: {pendlum: 1}, kd: 0}",
            "controller.kp: 'pendlum' is no joint of this robot, did you mean 'pendulum'?"},
           {"torque: {pendulum: [[0, 2", "torque: {pendlum: [[0, 2",
            "input: 'pendlum' is no joint with a motor of this robot, did you mean 'pendulum'?"},
           {"duration: 3 s", "duration: 3 s\noverride:\n  gravity: 3 m",
            "e.yaml:11: override.gravity: '3 m' is in m; allowed: a number in m/s^2"},
       }) {
    const std::string file = experiment(folder, "pendulum_trials.yaml", c.what, c.by);
    for (const char* command : {"check", "simulate", "preflight"}) {
      const Outcome outcome = run_program({command, file});
      expect_refusal(outcome);
      EXPECT_TRUE(holds(outcome.err, c.message)) << command;
    }
  }
}

TEST(Check, TellsValuesThatAreHardlyMeant) {
  const TemporaryFolder folder;
  const std::string file = experiment(folder, "pendulum_trials.yaml", "duration: 3 s",
                                      "duration: 3 s\noverride: {gravity: 98 m/s^2}");
  const Outcome outcome = run_program({"check", file});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "note: gravity = 98 m/s^2; usual: 9.81 m/s^2 on Earth"));

  const std::string problem =
      folder.write("slippery.yaml", "format: jaculus-problem/1\nextends: " + kProblems +
                                        "leap_tail.yaml\nname: grippy\nlimits: {friction: 35}\n");
  const Outcome grips = run_program({"check", problem});
  EXPECT_EQ(grips.exit_code, 0) << grips.err;
  EXPECT_TRUE(holds(grips.out, "note: friction = 35; usual: 0.1 (rubber on ice) to 1"));
}

TEST(Check, HintsAtAScaleThatTheExperimentCanJudge) {
  const TemporaryFolder folder;
  const auto effect = [&](const std::string& scale) {
    return folder.write("pull.yaml",
                        "format: jaculus-effect/1\nname: my_pull\ncaption: constant pull\n"
                        "at: {joint: pendulum}\nexperiment: " +
                            kProblems +
                            "pendulum_trials.yaml\nparameters:\n"
                            "  pull: {unit: N m, nominal: 0, bounds: [-10, 10], scale: " +
                            scale + "}\ntorque: pull\n");
  };
  const Outcome small = run_program({"check", effect("1e-6")});
  EXPECT_TRUE(holds(small.out, "hint: scale 1e-06 N m of pull is too small to be seen"));
  EXPECT_TRUE(holds(small.out, "try about 0.0"));
  const Outcome large = run_program({"check", effect("9")});
  EXPECT_TRUE(holds(large.out, "hint: scale 9 N m of pull is so large"));
  const Outcome right = run_program({"check", effect("0.05")});
  EXPECT_EQ(right.exit_code, 0) << right.out;
  EXPECT_FALSE(holds(right.out, "hint:")) << right.out;
}

TEST(Check, EndsWithOneBesideALogThatTheRobotCantMake) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_program({"simulate", kProblems + "pendulum_trials.yaml", "--trials", "1", "--quiet",
                         "--out", folder / "swing"})
                .exit_code,
            0);
  const std::string map = folder.write(
      "map.yaml",
      "format: jaculus-columns/1\nchannels:\n  time: {column: \"time [s]\", unit: s}\n"
      "  pendulum: {column: \"pendulum [rad]\", unit: rad}\n"
      "  pendulum_velocity: {column: \"pendulum_velocity [rad/s]\", unit: rad/s}\n"
      "  pendulum_torque: {column: \"pendulum_torque [N m]\", unit: N m, scale: 1000}\n"
      "  pendlum_current: {column: \"pendulum_torque [N m]\", unit: A}\n");
  const Outcome imported =
      run_program({"import", "csv", folder / "swing" / "trial_01" / "joints.csv", "--map", map,
                   "--robot", "ak80_pendulum", "--experiment", "pendulum", "--controller",
                   "{kind: measured, input: torque}", "--out", folder / "wrong"});
  EXPECT_EQ(imported.exit_code, 0) << imported.err;

  const Outcome checked = run_program({"check", folder / "wrong"});
  EXPECT_EQ(checked.exit_code, 1);
  EXPECT_TRUE(holds(run_program({"check", folder / "wrong", "--quiet"}).err, "_torque reaches"));
  for (const Outcome& outcome : {imported, checked}) {
    EXPECT_TRUE(holds(outcome.out, "_torque reaches")) << outcome.out;
    EXPECT_TRUE(holds(outcome.out, "the motor gives 12 N m at most")) << outcome.out;
    EXPECT_TRUE(holds(outcome.out, "pendlum_current, did you mean 'pendulum_current'?"))
        << outcome.out;
  }
}

/// The keys that a reader allows where it meets one that is none.
std::vector<std::string> allowed_keys(const std::string& message) {
  const std::size_t at = message.find("allowed: ");
  EXPECT_NE(at, std::string::npos) << message;
  std::stringstream list(message.substr(at + 9, message.find('\n', at) - at - 9));
  std::vector<std::string> keys;
  for (std::string key; std::getline(list, key, ',');)
    keys.push_back(key.substr(key.find_first_not_of(' ')));
  return keys;
}

TEST(Check, ExplainsEveryKeyThatReadersTake) {
  const TemporaryFolder folder;
  struct Case {
    const char *kind, *what, *by;
  };
  const Outcome simulated = run_program({"simulate", kProblems + "pendulum_trials.yaml", "--trials",
                                         "1", "--quiet", "--out", folder / "swing"});
  ASSERT_EQ(simulated.exit_code, 0);
  const std::string set = folder / "swing" / "dataset.yaml";
  for (const Case& c : {Case{"experiment", "duration: 3 s", "zzz: 3 s"},
                        {"experiment", "rate_hz: 500}\nduration", "zzz: 500}\nduration"},
                        {"experiment", "rate_hz: 500, channels", "zzz: 500, channels"},
                        {"dataset", "provenance:", "zzz:"},
                        {"dataset", "rate_hz: 500}", "zzz: 500}"},
                        {"effect", "caption:", "zzz:"},
                        {"effect", "at: {group:", "at: {zzz:"},
                        {"effect", "nominal: 0,", "zzz: 0,"},
                        {"effect", "derivative:", "zzz:"}}) {
    const bool dataset = std::string(c.kind) == "dataset";
    const std::string other = std::string(c.kind) == "effect"
                                  ? source_folder().string() + "/effects/lugre.yaml"
                                  : kProblems + "pendulum_trials.yaml";
    std::string text = bytes_of(dataset ? set : other);
    const std::string elsewhere = "experiment: ../problems/pendulum_trials.yaml\n";
    if (const std::size_t line = text.find(elsewhere); line != std::string::npos)
      text.erase(line, elsewhere.size());
    const std::size_t at = text.find(c.what);
    ASSERT_NE(at, std::string::npos) << c.what << " in " << text;
    text.replace(at, std::string(c.what).size(), c.by);
    const std::string file =
        dataset ? folder.write("swing/dataset.yaml", text) : folder.write("e.yaml", text);
    const std::string help = run_program({"check", "--explain", c.kind}).out;
    for (const std::string& key : allowed_keys(run_program({"check", file}).err))
      EXPECT_TRUE(std::regex_search(help, std::regex("\\n +(kp, )?" + key + "[ ,]"))) << key;
  }
  EXPECT_TRUE(holds(run_program({"check", "--explain", "robot"}).out, "rest_pose"));
  const Outcome none = run_program({"check", "--explain", "robto"});
  expect_refusal(none);
  EXPECT_TRUE(holds(none.err, "allowed: problem, robot, experiment, dataset, effect")) << none.err;
}

TEST(Simulate, SaysWhereAJointLeavesItsRange) {
  const TemporaryFolder folder;
  const Outcome free =
      run_program({"simulate", kProblems + "pendulum_trials.yaml", "--trials", "1"});
  EXPECT_FALSE(holds(free.out, "leaves its range")) << free.out;

  // The same robot with ends at its hinge.
  const std::string model = source_folder().string() + "/models/ak80_pendulum/";
  std::string urdf = bytes_of(model + "robot.urdf");
  const auto put = [&](const std::string& what, const std::string& by) {
    ASSERT_NE(urdf.find(what), std::string::npos) << what;
    urdf.replace(urdf.find(what), what.size(), by);
  };
  put("type=\"continuous\"", "type=\"revolute\"");
  put("<limit ", "<limit lower=\"-0.1\" upper=\"0.1\" ");
  std::filesystem::create_directory(folder / "robot");
  folder.write("robot/robot.urdf", urdf);
  folder.write("robot/robot.yaml", bytes_of(model + "robot.yaml"));
  const std::string file =
      experiment(folder, "pendulum_trials.yaml", "robot: ak80_pendulum", "robot: robot");
  const Outcome held = run_program({"simulate", file, "--trials", "1"});
  EXPECT_EQ(held.exit_code, 0) << held.err;
  EXPECT_TRUE(holds(held.out, "note: pendulum leaves its range of -0.1 to 0.1 rad")) << held.out;
}

TEST(Simulate, SaysWhereAMotorGivesLessThanItIsTold) {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& torque) {
    const std::string file =
        experiment(folder, "pendulum_trials.yaml", "[0.3 s, -2.5 N m]", "[0.3 s, " + torque + "]");
    const Outcome outcome = run_program({"simulate", file, "--trials", "1"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.out;
  };
  EXPECT_FALSE(holds(said("-12 N m"), "a motor's limits"));
  const std::string beyond = said("-12.1 N m");
  EXPECT_TRUE(holds(beyond, "limits let it give, first: pendulum at 0.3 s of ")) << beyond;
}

}  // namespace
}  // namespace jaculus::cli
