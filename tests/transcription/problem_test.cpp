#include "jaculus/transcription/problem.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <regex>
#include <set>

#include "jaculus/core/installation.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"
#include "transcription/problem_keys.h"

namespace jaculus::transcription {
namespace {

using test::holds;
using test::input_error_of;
using test::TemporaryFolder;

constexpr const char* kBase = R"(format: jaculus-problem/1
name: base
caption: as it was
robot: toy
override: {motors.tail.resistance: 0.22 ohm, tail.drag.coefficient: 2.3}
lock: {wing: 10 deg}
limits: {voltage: 7 V, torque: 3 N m}
bounds:
  position: {x: [-1 m, 1 m], tail: [-90 deg, 90 deg], wing: [0 deg, 20 deg]}
  velocity: {x: [-5 m/s, 5 m/s]}
phases:
  - {name: stand, contacts: [foot], intervals: 4, duration: [10 ms, 0.5 s]}
  - {name: fly, contacts: [], intervals: 2, duration: 0.1, mesh: [1, 3]}
initial: {at_rest: true, position: {x: 0, tail: [-10 deg, 30 deg]}}
final: {velocity: {x: [1 m/s, 5 m/s], tail: 0}}
constraints:
  - {type: friction}
  - {type: touchdown_pitch, height: 0.2 m, pitch: 0 deg}
objective:
  maximise: [{type: mean_acceleration}]
  minimise: [{type: torque_squared, weight: 1e-4}]
transcription: {scheme: trapezoidal, inputs: linear, check_interval_end: false}
guess: {kind: static, pose: {x: 0.1 m}, durations: [0.2, 0.1]}
solver: {tolerance: 1e-7, max_iterations: 50, starts: 3, seed: 7}
refinement: {max_rounds: 2, tolerance: 1e-5}
reference: {duration_s: 0.2 s, tail_momentum_share: 0.05}
)";

class ProblemFile : public ::testing::Test {
 protected:
  ProblemFile() {
    std::filesystem::create_directories(folder / "toy");
    folder.write("toy/robot.yaml", "name: toy\n");
    folder.write("toy/robot.urdf", "<robot/>\n");
    folder.write("base.yaml", kBase);
  }
  Problem read(const std::string& text) { return read_problem(folder.write("problem.yaml", text)); }
  std::string error(const std::string& text) {
    return input_error_of([&] { static_cast<void>(read(text)); });
  }
  /// The base file with `from` replaced.
  std::string changed(const std::string& from, const std::string& to) const {
    std::string text = kBase;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
  TemporaryFolder folder;
};

TEST_F(ProblemFile, ReadsEverySectionInSi) {
  const Problem p = read(kBase);
  EXPECT_EQ(p.name, "base");
  EXPECT_EQ(p.robot_folder, folder / "toy");
  ASSERT_EQ(p.overrides.size(), 2u);
  EXPECT_EQ(p.overrides[1].path, "tail.drag.coefficient");
  ASSERT_EQ(p.locks.size(), 1u);
  EXPECT_NEAR(p.locks[0].second, std::numbers::pi / 18, 1e-15);
  EXPECT_EQ(*p.voltage, 7.0);
  EXPECT_FALSE(p.current.has_value());
  EXPECT_NEAR(p.position_bounds.at("tail").upper, std::numbers::pi / 2, 1e-15);
  ASSERT_EQ(p.phases.size(), 2u);
  EXPECT_EQ(p.phases[0].duration.lower, 0.01);
  EXPECT_TRUE(p.phases[1].contacts.empty());
  EXPECT_TRUE(p.phases[1].duration.fixed());
  EXPECT_EQ(p.phases[1].mesh, (std::vector<double>{1, 3}));
  EXPECT_TRUE(p.initial.at_rest);
  EXPECT_EQ(p.final.velocity.at("x").lower, 1.0);
  EXPECT_EQ(p.transcription.scheme, Scheme::trapezoidal);
  EXPECT_EQ(p.transcription.inputs, InputHold::linear);
  EXPECT_FALSE(p.transcription.check_interval_end);
  EXPECT_EQ(p.guess.pose.at("x"), 0.1);
  EXPECT_EQ(p.solver.starts, 3);
  EXPECT_EQ(p.solver.seed, 7);
  EXPECT_EQ(p.refinement.max_rounds, 2);
  EXPECT_EQ(p.reference.at("duration_s"), 0.2);
}

TEST_F(ProblemFile, MinimisedCostsAreSubtractedFromMaximisedOnes) {
  const Problem p = read(kBase);
  EXPECT_TRUE(p.maximise);
  ASSERT_EQ(p.objective.size(), 2u);
  EXPECT_EQ(p.objective[0].weight, 1.0);
  EXPECT_EQ(p.objective[1].weight, -1e-4);
}

TEST_F(ProblemFile, ALockTakesWhatTheFileSaysOfThatCoordinate) {
  const Problem p = read(kBase);
  EXPECT_FALSE(p.position_bounds.contains("wing"));
  EXPECT_TRUE(holds(error(changed("wing: 10 deg", "wing: 40 deg")),
                    "problem.yaml:9: bounds.position.wing"));
}

TEST_F(ProblemFile, ExtendsMergesMapsAndTermsAndReplacesLists) {
  const Problem p = read(R"(format: jaculus-problem/1
extends: base.yaml
name: child
override: {motors.tail.resistance: ~, tail.drag.coefficient: 2.0}
limits: {voltage: 8 V}
lock: ~
bounds: {position: {wing: ~}}
phases:
  - {name: only, contacts: [foot], intervals: 3, duration: 1 s}
constraints:
  - {type: touchdown_pitch, height: 0.2 m, pitch: 15 deg}
  - {type: voltage}
guess: {kind: middle}
reference: ~
)");
  EXPECT_EQ(p.name, "child");
  EXPECT_TRUE(p.caption.empty());
  ASSERT_EQ(p.overrides.size(), 1u);
  EXPECT_EQ(p.overrides[0].value.number(dimension::none), 2.0);
  EXPECT_EQ(*p.voltage, 8.0);
  EXPECT_EQ(*p.torque, 3.0);
  EXPECT_TRUE(p.locks.empty());
  EXPECT_FALSE(p.position_bounds.contains("wing"));
  EXPECT_TRUE(p.position_bounds.contains("tail"));
  EXPECT_EQ(p.phases.size(), 1u);
  ASSERT_EQ(p.constraints.size(), 3u);
  EXPECT_EQ(p.constraints[0].type, "friction");
  EXPECT_NEAR(p.constraints[1].values.interval("pitch").lower, std::numbers::pi / 12, 1e-15);
  EXPECT_EQ(p.constraints[2].type, "voltage");
  EXPECT_EQ(p.guess.kind, "middle");
  EXPECT_TRUE(p.guess.durations.empty());
  EXPECT_TRUE(p.reference.empty());
  // A term that was inherited still speaks of the file that it stands in.
  EXPECT_TRUE(holds(p.constraints[0].node.error("x").what(), "base.yaml:17: constraints[0]"));
}

TEST_F(ProblemFile, AContradictionIsToldInTheFileThatMakesIt) {
  const std::string head = "format: jaculus-problem/1\nextends: base.yaml\nname: child\n";
  struct Case {
    const char *text, *place, *of;
  };
  for (const Case& c : {
           Case{"lock: {tail: 40 deg}\n", "problem.yaml:4: lock.tail: 0.698132 contradicts ",
                "initial.position.tail: [-0.174533, 0.523599] ("},
           {"bounds: {position: {x: [0.5 m, 1 m]}}\n",
            "problem.yaml:4: bounds.position.x: [0.5, 1] leaves out ", "initial.position.x: 0 ("},
           {"final: {at_rest: true}\n", "problem.yaml:4: final.at_rest: true contradicts ",
            "final.velocity.x: [1, 5] ("},
           {"phases:\n  - {name: only, contacts: [foot], intervals: 3, duration: 1 s}\n",
            "problem.yaml:5: phases[0]: 1 in all; allowed: as many phases as the guess has "
            "durations: 2 (",
            "base.yaml"},
           {"phases:\n  - {name: a, contacts: [foot], intervals: 3, duration: 1 s}\n"
            "  - {name: b, contacts: [], intervals: 3, duration: 0.1 s}\n",
            "problem.yaml:5: phases[0].duration: 1 s leaves out the guess's 0.2 s (", "base.yaml"},
       }) {
    const std::string message = error(head + c.text);
    EXPECT_TRUE(holds(message, c.place));
    EXPECT_TRUE(holds(message, c.of));
    EXPECT_TRUE(holds(message, "base.yaml:")) << message;
  }
}

TEST_F(ProblemFile, ALimitInNewtonsIsOfJointsThatSlide) {
  const Problem turning = read(kBase);
  EXPECT_EQ(*turning.torque, 3.0);
  EXPECT_FALSE(turning.force);
  const Problem sliding = read(changed("torque: 3 N m", "torque: 300 N"));
  EXPECT_EQ(*sliding.force, 300.0);
  EXPECT_FALSE(sliding.torque);
  const Problem plain = read(changed("torque: 3 N m", "torque: 3"));
  EXPECT_EQ(*plain.torque, 3.0);
  EXPECT_EQ(*plain.force, 3.0);
  EXPECT_TRUE(holds(error(changed("torque: 3 N m", "torque: 3 V")),
                    "problem.yaml:7: limits.torque: '3 V' is in V; allowed: a number in N m, or a "
                    "string with such a unit, or in N for joints that slide"));
}

TEST_F(ProblemFile, CyclicExtendsNamesBothPlaces) {
  folder.write("a.yaml", "format: jaculus-problem/1\nname: a\nextends: b.yaml\n");
  folder.write("b.yaml", "format: jaculus-problem/1\nextends: a.yaml\nname: b\n");
  const std::string message =
      input_error_of([&] { static_cast<void>(read_problem(folder / "a.yaml")); });
  EXPECT_TRUE(holds(message, "b.yaml:2: extends"));
  EXPECT_TRUE(holds(message, "a.yaml:3"));
  EXPECT_TRUE(holds(error("format: jaculus-problem/1\nname: p\nextends: problem.yaml\n"),
                    "problem.yaml:3"));
}

struct Bad {
  const char* from;
  const char* to;
  const char* place;
  const char* what;
};

TEST_F(ProblemFile, RefusesWhatCantBeMeant) {
  const Bad cases[] = {
      {"jaculus-problem/1", "jaculus-problem/2", ":1: format", "allowed: jaculus-problem/1"},
      {"name: base", "nam: base", ":2: ", "did you mean 'name'?"},
      {"name: base", "name: a/b", ":2: name", "letters, digits"},
      {"robot: toy", "robot: toi", ":4: robot", "unknown robot 'toi'"},
      {"voltage: 7 V", "voltage: 7 A", ":7: limits.voltage", "V"},
      {"voltage: 7 V", "voltage: -7 V", ":7: limits.voltage", "allowed"},
      {"voltage: 7 V", "voltage: 0 V", ":7: limits.voltage", "positive"},
      {"voltage: 7 V", "volts: 7 V", ":7: limits", "voltage"},
      {"[-1 m, 1 m]", "[1 m, -1 m]", ":9: bounds.position.x", "above"},
      {"[-1 m, 1 m]", "[-1 deg, 1 deg]", ":9: bounds.position.x", "m"},
      {"intervals: 4", "intervals: 0", ":12: phases[0].intervals", "1 to 10000"},
      {"intervals: 4", "intervals: 1.5", ":12: phases[0].intervals", "whole number"},
      {"[10 ms, 0.5 s]", "[0 s, 0.5 s]", ":12: phases[0].duration", "positive"},
      {"[10 ms, 0.5 s]", "[0.6 s, 0.5 s]", ":12: phases[0].duration", "lower <= upper"},
      {"name: fly", "name: stand", ":13: phases[1].name", "unique"},
      {"contacts: [foot]", "contacts: [foot, foot]", ":12: phases[0].contacts", "twice"},
      {"mesh: [1, 3]", "mesh: [1, 3, 1]", ":13: phases[1].mesh", "allowed: 2"},
      {"mesh: [1, 3]", "mesh: [1, -3]", ":13: phases[1].mesh", "positive"},
      {"position: {x: 0,", "position: {x: 3,", ":14: initial.position.x", "bounds.position.x"},
      {"initial: {at_rest: true,", "initial: {at_rest: true, velocity: {tail: 1},",
       ":14: initial.velocity.tail", "at_rest"},
      {"{type: friction}", "friction", ":17: constraints[0]", "allowed: {type: ..., ...}"},
      {"{type: friction}", "{typ: friction}", ":17: constraints[0]", "'type' is missing"},
      {"{type: friction}", "{type: friction, phases: [stnd]}", ":17: constraints[0].phases[0]",
       "did you mean 'stand'?"},
      {"{type: friction}", "{type: touchdown_pitch}", ":18: constraints[1]", "twice"},
      {"weight: 1e-4", "weight: -1e-4", ":21: objective.minimise[0].weight", "positive"},
      {"weight: 1e-4", "weight: .nan", ":21: objective.minimise[0].weight", "allowed"},
      {"trapezoidal", "trapezoid", ":22: transcription.scheme", "did you mean 'trapezoidal'?"},
      {"kind: static, pose", "kind: middle, pose", ":23: guess.pose", "kind: static"},
      {"durations: [0.2, 0.1]", "durations: [0.2]", ":23: guess.durations", "one a phase"},
      {"durations: [0.2, 0.1]", "durations: [2.0, 0.1]", ":23: guess.durations", "stand"},
      {"kind: static, pose: {x: 0.1 m}", "kind: file, file: no.json", ":23: guess.file",
       "not found"},
      {"kind: static, pose: {x: 0.1 m}", "kind: line, poses: [{x: 0}]", ":23: guess.poses",
       "two poses"},
      {"tolerance: 1e-7", "tolerance: 0", ":24: solver.tolerance", "allowed"},
      {"duration_s: 0.2 s", "duraton_s: 0.2 s", ":26: reference", "did you mean 'duration_s'?"},
  };
  for (const Bad& bad : cases) {
    SCOPED_TRACE(bad.to);
    const std::string message = error(changed(bad.from, bad.to));
    EXPECT_TRUE(holds(message, std::string("problem.yaml") + bad.place));
    EXPECT_TRUE(holds(message, bad.what));
  }
}

TEST_F(ProblemFile, NamesRequiredKeysThatNoFileGives) {
  EXPECT_TRUE(holds(error("format: jaculus-problem/1\nname: p\n"), "'robot' is missing"));
  EXPECT_TRUE(
      holds(error("format: jaculus-problem/1\nname: p\nrobot: toy\n"), "'phases' is missing"));
  EXPECT_TRUE(holds(error("format: jaculus-problem/1\nname: p\nrobot: toy\nphases: []\n"),
                    "no phases given"));
}

/// One foot, a sliding base, a tail with a motor, a wing.
model::PlanarModel toy() {
  model::PlanarModel m;
  m.base_free = {true, false, false};
  m.bodies.resize(3);
  m.bodies[1].joint = "tail";
  m.bodies[1].parent = 0;
  m.bodies[2].joint = "wing";
  m.bodies[2].parent = 0;
  m.coordinates = {{"x", false, {}}, {"tail", true, {-2.0, 2.0}}, {"wing", true, {}}};
  m.joint_map = Matrix::Zero(3, 3);
  m.joint_map(1, 1) = m.joint_map(2, 2) = 1.0;
  m.joint_offset = Vector::Zero(3);
  m.feet = {{"foot", 0, Vec2::Zero(), 1}};
  model::PlanarMotor motor;
  motor.joint = "tail";
  motor.body = 1;
  motor.voltage = 16.0;
  motor.torque_limit = 5.0;
  m.motors = {motor};
  return m;
}

TEST_F(ProblemFile, ChecksNamesUnitsAndLimitsAgainstTheRobot) {
  EXPECT_NO_THROW(check_problem(read(kBase), toy()));
  const Bad cases[] = {
      {"contacts: [foot]", "contacts: [fooot]", ":12: phases[0].contacts[0]",
       "did you mean 'foot'?"},
      {"x: [-1 m, 1 m], tail", "x: [-1 m, 1 m], tial", ":9: bounds.position.tial",
       "did you mean 'tail'?"},
      {"tail: [-10 deg, 30 deg]", "tail: [-0.1 m, 0.3 m]", ":14: initial.position.tail", "rad"},
      {"tail: 0}", "tayl: 0}", ":15: final.velocity.tayl", "allowed: x, tail, wing"},
      {"lock: {wing: 10 deg}", "lock: {wink: 10 deg}", ":6: lock.wink", "did you mean 'wing'?"},
      {"{type: friction}", "{type: friction, feet: [hand]}", ":17: constraints[0].feet[0]",
       "allowed: foot"},
      {"{type: friction}", "{type: voltage, motors: [wing]}", ":17: constraints[0].motors[0]",
       "allowed: tail"},
      {"pose: {x: 0.1 m}", "pose: {y: 0.1}", ":23: guess.pose.y", "allowed: x, tail, wing"},
      {"voltage: 7 V", "voltage: 17 V", ":7: limits.voltage", "at most 16 V"},
      {"torque: 3 N m", "torque: 6 N m", ":7: limits.torque", "at most 5 N m"},
      {"tail: [-90 deg, 90 deg]", "tail: [2.5, 3.0]", ":14: initial.position.tail",
       "bounds.position.tail"},
  };
  for (const Bad& bad : cases) {
    SCOPED_TRACE(bad.to);
    const std::string text = changed(bad.from, bad.to);
    const std::string message = input_error_of([&] { check_problem(read(text), toy()); });
    EXPECT_TRUE(holds(message, std::string("problem.yaml") + bad.place));
    EXPECT_TRUE(holds(message, bad.what));
  }
}

TEST_F(ProblemFile, PlanningModelTakesLimitsAndLocks) {
  const model::PlanarModel model = planning_model(read(kBase), toy());
  EXPECT_EQ(model.motors.at(0).voltage, 7.0);
  EXPECT_EQ(model.motors.at(0).torque_limit, 3.0);
  EXPECT_EQ(model.coordinate_index("wing"), -1);
  EXPECT_EQ(model.size(), 2);
}

TEST(ProblemKeys, AreAllExplainedOnce) {
  // Wrapped lines are joined again before they are searched.
  const std::string text = std::regex_replace(explain_problem(), std::regex("\\s+"), " ");
  std::set<std::string> sections;
  for (const problem_keys::Section& section : problem_keys::sections(term_catalogue())) {
    EXPECT_TRUE(sections.insert(section.name).second) << section.name;
    EXPECT_NE(text.find(section.meaning), std::string::npos) << section.name;
    std::set<std::string> keys;
    for (const Key& key : section.keys) {
      EXPECT_TRUE(keys.insert(key.name).second) << section.name << "." << key.name;
      EXPECT_FALSE(key.meaning.empty()) << section.name << "." << key.name;
      EXPECT_NE(text.find(key.meaning), std::string::npos) << section.name << "." << key.name;
    }
  }
}

TEST(ProblemKeys, TellWhatCountsWhereOneIsAbsent) {
  const std::string text = std::regex_replace(explain_problem(), std::regex("\\s+"), " ");
  EXPECT_NE(text.find("tolerance [-] of the scaled optimality error (else: 1e-06)"),
            std::string::npos);
  EXPECT_NE(text.find("scheme hermite_simpson (third-order defects, midpoints) or trapezoidal "
                      "(else: hermite_simpson)"),
            std::string::npos);
  EXPECT_NE(text.find("foot the foot (required)"), std::string::npos);
  EXPECT_NE(text.find("coefficient [-] of Coulomb friction (else: limits.friction)"),
            std::string::npos);
}

TEST(ProblemFiles, EveryShippedProblemFitsItsRobot) {
  int problems = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() / "problems")) {
    if (entry.path().extension() != ".yaml") continue;
    const yaml::Node node = yaml::Node::load(entry.path());
    if (node.find("format") && node.at("format").text() != "jaculus-problem/1") continue;
    SCOPED_TRACE(entry.path().string());
    ++problems;
    const Problem problem = read_problem(entry.path());
    EXPECT_EQ(problem.name, entry.path().stem().string());
    EXPECT_NO_THROW(
        check_problem(problem, model::read_robot(problem.robot_folder, problem.overrides).planar));
  }
  EXPECT_GE(problems, 16);
}

TEST(ProblemFiles, LeapVariantsDifferOnlyInTheirTail) {
  const auto read = [](const char* name) {
    return read_problem(source_folder() / "problems" / (std::string(name) + ".yaml"));
  };
  const auto pitch = [](const Problem& p) {
    for (const TermSpec& term : p.constraints) {
      if (term.type == "touchdown_pitch") return term.values.interval("pitch").lower;
    }
    return kNaN;
  };
  constexpr double k15 = std::numbers::pi / 12;
  EXPECT_EQ(pitch(read("leap_tail")), 0.0);
  EXPECT_NEAR(pitch(read("leap_tail_15deg")), k15, 1e-12);
  EXPECT_NEAR(pitch(read("leap_inactive")), k15, 1e-12);
  EXPECT_EQ(pitch(read("leap_inactive_0deg")), 0.0);
  EXPECT_NEAR(pitch(read("leap_inertial_15deg")), k15, 1e-12);
  EXPECT_EQ(read("leap_tailless").locks.size(), 0u);
  ASSERT_EQ(read("leap_inactive").locks.size(), 1u);
  EXPECT_NEAR(read("leap_inactive").locks[0].second, -std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(read("leap_tailless").constraints.size(), read("leap_tail").constraints.size());
  EXPECT_EQ(read("leap_tailless").voltage, read("leap_tail").voltage);
}

}  // namespace
}  // namespace jaculus::transcription
