// Bad files through the program, as a user meets them: exit code 2, nothing on standard output, one
// message that says where (file:line), which key, what was given and what is allowed.

#include <gtest/gtest.h>

#include <iterator>
#include <string>

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

enum class Where { problem, robot, urdf };

struct FileCase {
  Where where;
  const char* from;     ///< text of the good file
  const char* to;       ///< what stands there instead
  const char* place;    ///< "file:line" that the message must name
  const char* key;      ///< key or value it must name
  const char* allowed;  ///< allowed value, nearest name or reason
};

constexpr FileCase kFileCases[] = {
    // problem: keys and structure
    {Where::problem, "format: jaculus-problem/1", "format: jaculus-problem/7", "problem.yaml:1",
     "format", "jaculus-problem/1"},
    {Where::problem, "format: jaculus-problem/1", "formt: jaculus-problem/1", "problem.yaml:1",
     "formt", "'format'"},
    {Where::problem, "name: toy_problem", "name: [a]", "problem.yaml:2", "name", "text"},
    {Where::problem, "name: toy_problem", "name: ../up", "problem.yaml:2", "name",
     "letters, digits"},
    {Where::problem, "robot: toy", "robot: tyo", "problem.yaml:3", "tyo", "robot.yaml"},
    {Where::problem, "limits: {voltage", "limit: {voltage", "problem.yaml:5", "limit",
     "did you mean 'limits'?"},
    {Where::problem, "limits: {voltage", "limits: {voltge", "problem.yaml:5", "voltge",
     "did you mean 'voltage'?"},
    // plain numbers are SI: good input, see below
    {Where::problem, "voltage: 7 V", "voltage: 7", "", "", ""},
    {Where::problem, "voltage: 7 V", "voltage: 7 A", "problem.yaml:5", "limits.voltage", "V"},
    {Where::problem, "voltage: 7 V", "voltage: seven", "problem.yaml:5", "limits.voltage", "seven"},
    {Where::problem, "voltage: 7 V", "voltage: .nan", "problem.yaml:5", "limits.voltage",
     "allowed"},
    {Where::problem, "voltage: 7 V", "voltage: .inf", "problem.yaml:5", "limits.voltage",
     "allowed"},
    {Where::problem, "voltage: 7 V", "voltage: -7 V", "problem.yaml:5", "limits.voltage",
     "at least 0 V"},
    {Where::problem, "voltage: 7 V", "voltage: 0 V", "problem.yaml:5", "limits.voltage",
     "positive"},
    {Where::problem, "voltage: 7 V", "voltage: 20 V", "problem.yaml:5", "limits.voltage",
     "at most 16 V"},
    {Where::problem, "torque: 3 N m", "torque: 4 N m", "problem.yaml:5", "limits.torque",
     "at most 3 N m"},
    {Where::problem, "friction: 0.5", "friction: 0.5 m", "problem.yaml:5", "limits.friction", "m"},
    {Where::problem, "voltage: 7 V,", "voltage: 7 V, voltage: 8 V,", "problem.yaml:5", "voltage",
     "twice"},
    // problem: override
    {Where::problem, "motors.swing.resistance", "motors.swing.resistanc", "problem.yaml:4",
     "resistanc", "did you mean"},
    {Where::problem, "0.22 ohm", "0.22 V", "problem.yaml:4", "motors.swing.resistance", "ohm"},
    {Where::problem, "0.22 ohm", "-0.22 ohm", "problem.yaml:4", "motors.swing.resistance",
     "allowed"},
    {Where::problem, "{motors.swing.resistance: 0.22 ohm}",
     "{motors.swing.resistance: =motors.swing.torque_constant}", "problem.yaml:4", "motors.swing",
     "same kind and unit"},
    {Where::problem, "{motors.swing.resistance: 0.22 ohm}",
     "{friction: =gravity, gravity: =friction}", "problem.yaml:4", "friction", "allowed"},
    {Where::problem, "motors.swing.resistance: 0.22 ohm",
     "motors.swing.saturation_linear: =motors.swing.saturation_linear", "problem.yaml:4",
     "saturation_linear", "circle"},
    // problem: bounds
    {Where::problem, "x: [-1 m, 1 m]", "x: [1 m, -1 m]", "problem.yaml:7", "bounds.position.x",
     "lower <= upper"},
    {Where::problem, "x: [-1 m, 1 m]", "x: [-1 m]", "problem.yaml:7", "bounds.position.x",
     "[lower, upper]"},
    {Where::problem, "x: [-1 m, 1 m]", "x: [-1 s, 1 s]", "problem.yaml:7", "bounds.position.x",
     "m"},
    {Where::problem, "swing: [-90", "swng: [-90", "problem.yaml:7", "swng",
     "did you mean 'swing'?"},
    {Where::problem, "swing: [-90 deg, 90 deg]", "swing: [-1 m, 1 m]", "problem.yaml:7",
     "bounds.position.swing", "rad"},
    {Where::problem, "swing: [-90 deg, 90 deg]", "swing: [4, 5]", "problem.yaml:7",
     "bounds.position.swing", "[-3, 3]"},
    // problem: phases
    {Where::problem, "name: fly", "name: stand", "problem.yaml:10", "phases[1].name", "unique"},
    {Where::problem, "contacts: [foot]", "contacts: [feet]", "problem.yaml:9",
     "phases[0].contacts[0]", "did you mean 'foot'?"},
    {Where::problem, "contacts: [foot]", "contacts: [foot, foot]", "problem.yaml:9",
     "phases[0].contacts", "once"},
    {Where::problem, "contacts: [foot]", "contacts: foot", "problem.yaml:9", "phases[0].contacts",
     "a list"},
    {Where::problem, "[foot], intervals: 4", "[foot], intervals: 0", "problem.yaml:9",
     "phases[0].intervals", "1 to 10000"},
    {Where::problem, "[foot], intervals: 4", "[foot], intervals: 4.5", "problem.yaml:9",
     "phases[0].intervals", "whole number"},
    {Where::problem, "[foot], intervals: 4", "[foot], interval: 4", "problem.yaml:9", "interval",
     "did you mean 'intervals'?"},
    {Where::problem, "intervals: 4, duration: [10 ms, 500 ms]}\n  - {name: fly",
     "intervals: 4}\n  - {name: fly", "problem.yaml:9", "duration", "missing"},
    {Where::problem, "duration: [10 ms, 500 ms]", "duration: [0 s, 1 s]", "problem.yaml:9",
     "phases[0].duration", "positive"},
    {Where::problem, "duration: [10 ms, 500 ms]", "duration: [10 mm, 1 s]", "problem.yaml:9",
     "phases[0].duration", "s"},
    // problem: ends
    {Where::problem, "position: {pitch: 0}", "position: {pich: 0}", "problem.yaml:11", "pich",
     "did you mean 'pitch'?"},
    {Where::problem, "position: {pitch: 0}", "position: {pitch: 2}", "problem.yaml:11",
     "initial.position.pitch", "[-1, 1]"},
    {Where::problem, "at_rest: true", "at_rest: yes please", "problem.yaml:11", "initial.at_rest",
     "true or false"},
    {Where::problem, "initial: {at_rest: true,", "initial: {at_rest: true, velocity: {x: 1},",
     "problem.yaml:11", "initial.velocity.x", "at_rest"},
    {Where::problem, "x: [0.1 m/s, 5 m/s]", "x: [0.1 m, 5 m]", "problem.yaml:12",
     "final.velocity.x", "m/s"},
    // problem: terms
    {Where::problem, "- {type: friction}", "- friction", "problem.yaml:14", "constraints[0]",
     "{type: ..., ...}"},
    {Where::problem, "- {type: friction}", "- {feet: [foot]}", "problem.yaml:14", "constraints[0]",
     "'type' is missing"},
    {Where::problem, "- {type: friction}", "- {type: friction, feet: [fot]}", "problem.yaml:14",
     "constraints[0].feet[0]", "did you mean 'foot'?"},
    {Where::problem, "phases: [stand]}", "phases: [stnd]}", "problem.yaml:15",
     "constraints[1].phases[0]", "did you mean 'stand'?"},
    {Where::problem, "- {type: friction}", "- {type: normal_force, min: 2 N}", "problem.yaml:15",
     "normal_force", "twice"},
    {Where::problem, "maximise: [", "maximize: [", "problem.yaml:17", "maximize",
     "did you mean 'maximise'?"},
    {Where::problem, "weight: 1", "weight: 0", "problem.yaml:17", "objective.maximise[0].weight",
     "positive"},
    {Where::problem, "[{type: mean_acceleration, weight: 1}]", "[]", "problem.yaml:17", "objective",
     "one or more"},
    {Where::problem, "- {type: friction}", "- {type: frictoin}", "problem.yaml:14",
     "constraints[0]", "did you mean 'friction'?"},
    {Where::problem, "- {type: friction}", "- {type: friction, coeficient: 1}", "problem.yaml:14",
     "constraints[0]", "did you mean 'coefficient'?"},
    {Where::problem, "min: 1 N", "min: 1 m", "problem.yaml:15", "constraints[1].min", "N"},
    {Where::problem, "{type: mean_acceleration, weight: 1}", "{type: mean_aceleration}",
     "problem.yaml:17", "objective.maximise[0]", "did you mean 'mean_acceleration'?"},
    {Where::problem, "{type: mean_acceleration, weight: 1}", "{type: final_velocity, of: bse}",
     "problem.yaml:17", "objective.maximise[0].of", "did you mean 'base'?"},
    // problem: how it is solved
    {Where::problem, "scheme: hermite_simpson", "scheme: hermite_simson", "problem.yaml:18",
     "transcription.scheme", "did you mean 'hermite_simpson'?"},
    {Where::problem, "inputs: held", "inputs: hold", "problem.yaml:18", "transcription.inputs",
     "did you mean 'held'?"},
    {Where::problem, "kind: static", "kind: statik", "problem.yaml:19", "guess.kind",
     "did you mean 'static'?"},
    {Where::problem, "kind: static", "kind: file, file: old.json", "problem.yaml:19", "guess.file",
     "solution.json"},
    {Where::problem, "kind: static", "kind: line", "problem.yaml:19", "poses", "missing"},
    {Where::problem, "kind: static", "kind: static, durations: [0.1]", "problem.yaml:19",
     "guess.durations", "one a phase"},
    {Where::problem, "tolerance: 1e-6", "tolerance: 2", "problem.yaml:20", "solver.tolerance",
     "allowed"},
    {Where::problem, "tolerance: 1e-6", "max_iter: 5", "problem.yaml:20", "max_iter",
     "max_iterations"},
    {Where::problem, "format: jaculus-problem/1\n",
     "format: jaculus-problem/1\nextends: problem.yaml\n", "problem.yaml:2", "extends",
     "themselves"},
    {Where::problem, "format: jaculus-problem/1\n",
     "format: jaculus-problem/1\nextends: base.yaml\n", "problem.yaml:2", "extends", "not found"},
    // YAML itself
    {Where::problem, "robot: toy\n", "robot: [toy\n", "problem.yaml:", "YAML", "allowed"},
    {Where::problem, "robot: toy\n", "robot: *nowhere\n", "problem.yaml:", "anchor", ""},
    {Where::problem, "robot: toy\n", "robot: toy\n---\na: b\n", "problem.yaml:", "second document",
     "one document"},
    {Where::problem, "robot: toy\n", "robot: toy\nrobot: toy\n", "problem.yaml:4", "robot", "once"},
    // robot.yaml
    {Where::robot, "format: jaculus-robot/1", "format: jaculus-robot/2", "robot.yaml:1", "format",
     "jaculus-robot/1"},
    {Where::robot, "base: floating", "base: flotting", "robot.yaml:2", "base",
     "did you mean 'floating'?"},
    {Where::robot, "gravity: 9.81 m/s^2", "gravity: 9.81 m/s", "robot.yaml:3", "gravity", "m/s^2"},
    {Where::robot, "friction: 0.8", "friction: -0.8", "robot.yaml:4", "friction", "allowed"},
    {Where::robot, "link: arm", "link: amr", "robot.yaml:6", "amr", "did you mean 'arm'?"},
    {Where::robot, "point: [0, -1]", "point: [0, -1, 0]", "robot.yaml:6", "point", "two"},
    {Where::robot, "  swing:\n", "  swign:\n", "robot.yaml:", "swign", "did you mean 'swing'?"},
    {Where::robot, "resistance: 0.2 ohm", "resistance: 0.2 m", "robot.yaml:11", "resistance",
     "ohm"},
    {Where::robot, "    gear: 1\n", "    gear: 0\n", "robot.yaml:17", "gear", "allowed"},
    {Where::robot, "efficiency: 1", "efficiency: 1.5", "robot.yaml:18", "efficiency", "allowed"},
    {Where::robot, "gear: 1", "gaer: 1", "robot.yaml:17", "gaer", "did you mean 'gear'?"},
    {Where::robot, "motors:",
     "loops: {a: {link_a: arm, link_b: amr, point_a: [0, -1], point_b: [0, 0], dependent: [swing, "
     "kick]}}\nmotors:",
     "robot.yaml:7", "amr", "did you mean 'arm'?"},
    {Where::robot, "motors:",
     "loops: {a: {link_a: arm, link_b: base, point_a: [0, -1], point_b: [0, 0], dependent: [swing, "
     "swng]}}\nmotors:",
     "robot.yaml:7", "swng", "did you mean 'swing'?"},
    // robot.urdf
    {Where::urdf, "<mass value=\"1\"/>", "<mass value=\"-1\"/>", "robot.urdf:6", "mass", "arm"},
    {Where::urdf, "<mass value=\"1\"/>", "<mass value=\"one\"/>", "robot.urdf:7", "mass", "one"},
    {Where::urdf, "izz=\"0.01\"", "izz=\"big\"", "robot.urdf:", "inertia", "big"},
    {Where::urdf, "child link=\"arm\"", "child link=\"leg\"", "robot.urdf:", "leg", ""},
    {Where::urdf, "</robot>", "", "robot.urdf", "", ""},
    {Where::urdf, "axis xyz=\"0 1 0\"", "axis xyz=\"0 0 0\"", "robot.urdf:9", "axis", "swing"},
};

TEST_F(BadInput, TheUnchangedFilesAreGood) {
  const Outcome outcome = run_program({"check", "problem.yaml", "toy"}, folder.path());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(holds(outcome.out, "toy_problem"));
}

TEST_F(BadInput, EveryFaultOfAFileIsNamedWithItsPlace) {
  static_assert(std::size(kFileCases) >= 60);
  for (const FileCase& c : kFileCases) {
    SCOPED_TRACE(std::string(c.from) + "  ->  " + c.to);
    restore();
    const char* name = c.where == Where::problem ? "problem.yaml"
                       : c.where == Where::robot ? "toy/robot.yaml"
                                                 : "toy/robot.urdf";
    std::string text = bytes_of(folder / name);
    const std::size_t at = text.find(c.from);
    ASSERT_NE(at, std::string::npos);
    folder.write(name, text.replace(at, std::string(c.from).size(), c.to));
    const Outcome outcome = run_program({"check", "problem.yaml"}, folder.path());
    if (std::string(c.place).empty()) {
      EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
      continue;
    }
    expect_refusal(outcome);
    EXPECT_TRUE(holds(outcome.err, c.place));
    EXPECT_TRUE(holds(outcome.err, c.key));
    EXPECT_TRUE(holds(outcome.err, c.allowed));
  }
}

TEST_F(BadInput, GarbageIsRefusedQuicklyAndInOneLine) {
  std::string garbage(10'000'000, '\0');
  unsigned state = 1;
  for (char& c : garbage) {
    state = state * 1664525u + 1013904223u;
    c = static_cast<char>(state >> 24);
  }
  folder.write("garbage.yaml", garbage);
  folder.write("huge.yaml", std::string(11'000'000, 'a'));
  folder.write("empty.yaml", "");
  folder.write("list.yaml", "[1, 2]");
  for (const char* name : {"garbage.yaml", "huge.yaml", "empty.yaml", "list.yaml"}) {
    SCOPED_TRACE(name);
    const Outcome outcome = run_program({"check", name}, folder.path());
    expect_refusal(outcome);
    EXPECT_TRUE(holds(outcome.err, name));
    EXPECT_LT(outcome.err.size(), 500u);
  }
}

}  // namespace
}  // namespace jaculus::cli
