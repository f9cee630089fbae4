// `jaculus check` of experiments, problems, effects: what the run refuses is refused, what is
// unusual told.

#include <gtest/gtest.h>

#include <string>

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

}  // namespace
}  // namespace jaculus::cli
