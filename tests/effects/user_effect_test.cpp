// Effects that users write: what files are refused and how, their entries in a catalogue, and every
// file of effects/ through the checks.

#include "jaculus/effects/user_effect.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/effects/check.h"
#include "jaculus/effects/select.h"
#include "jaculus/model/robot.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::effects {
namespace {

namespace fs = std::filesystem;
using simulation::ActionKind;
using simulation::Plant;
using test::holds;

model::PlanarModel robot(const std::string& name) {
  return model::read_robot(source_folder() / "models" / name).planar;
}

// Files
// -------------------------------------------------------------------------------------------------

/// A sound file, a line of which tests replace.
const char* const kSound = R"yaml(format: jaculus-effect/1
name: sticky
caption: something sticky
at: {joint: elbow}
parameters:
  level: {unit: N m, nominal: 0, bounds: [0, 1], scale: 0.1}
  rate: {unit: rad/s, nominal: 1, bounds: [0.1, 5], scale: 0.5}
values:
  share: {unit: "-", value: qd/rate}
states:
  x: {unit: "-", initial: 0, derivative: "(share - x)*abs(qd)"}
torque: "-level*tanh(share)*(1 + x)"
)yaml";

std::string with_line(const std::string& old_line, const std::string& new_line) {
  std::string text = kSound;
  const std::size_t at = text.find(old_line);
  EXPECT_NE(at, std::string::npos) << old_line;
  return text.replace(at, old_line.size(), new_line);
}

std::string refusal(const std::string& text) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.write("sticky.yaml", text);
  return test::input_error_of([&] { (void)read_user_effect(file); });
}

TEST(UserEffect, OfASoundFileIsAnEntryAsOthers) {
  const test::TemporaryFolder folder;
  const UserEffect user = read_user_effect(folder.write("sticky.yaml", kSound));
  EXPECT_TRUE(effect_faults(user.effect).empty());
  EXPECT_EQ(user.effect.name, "sticky");
  ASSERT_EQ(user.effect.parameters.size(), 2u);
  EXPECT_EQ(user.effect.parameters[1].unit, "rad/s");
  EXPECT_EQ(user.effect.parameters[1].nominal, 1.0);

  EXPECT_TRUE(user.effect.applies(robot("double_pendulum")));
  EXPECT_FALSE(user.effect.applies(robot("ak80_pendulum")));
  Plant plant = simulation::nominal_plant(robot("double_pendulum"));
  user.effect.apply(user.effect.nominal(), plant);
  EXPECT_TRUE(plant.laws.empty());
  user.effect.apply(user.effect.probed(), plant);
  EXPECT_EQ(plant.laws.size(), 1u);
}

// Runs share what is compiled, one after the other: none sees another's values.
TEST(UserEffect, RunsOfOneLawDoNotMix) {
  const test::TemporaryFolder folder;
  const UserEffect user = read_user_effect(folder.write("sticky.yaml", kSound));
  const auto torque = [](const simulation::LawFunctions& run) {
    const double readings[] = {1.0}, states[] = {0.0};
    double actions[] = {0.0}, rates[] = {0.0};
    run.act(readings, states, actions, rates);
    return actions[0];
  };
  const auto law_at = [&](double level, double rate) {
    Plant plant = simulation::nominal_plant(robot("double_pendulum"));
    user.effect.apply(Vector::Map(std::array{level, rate}.data(), 2), plant);
    return plant.laws.front();
  };
  const simulation::Law strong = law_at(1.0, 0.5), weak = law_at(0.1, 2.0);
  {
    const simulation::LawFunctions one = strong.functions(), other = weak.functions();
    EXPECT_DOUBLE_EQ(torque(one), -std::tanh(2.0));
    EXPECT_DOUBLE_EQ(torque(other), -0.1 * std::tanh(0.5));
    EXPECT_DOUBLE_EQ(torque(one), -std::tanh(2.0));
  }
  EXPECT_DOUBLE_EQ(torque(weak.functions()), -0.1 * std::tanh(0.5));
  EXPECT_DOUBLE_EQ(torque(strong.functions()), -std::tanh(2.0));
}

TEST(UserEffect, FaultsAreToldWithTheirPlace) {
  const auto expect = [](const std::string& old_line, const std::string& new_line,
                         const std::string& place, const std::string& what) {
    const std::string message = refusal(with_line(old_line, new_line));
    EXPECT_TRUE(holds(message, "sticky.yaml:" + place)) << new_line;
    EXPECT_TRUE(holds(message, what)) << new_line;
  };
  const std::string torque = "\"-level*tanh(share)*(1 + x)\"";
  const auto expect_torque = [&](const std::string& formula, const std::string& what) {
    expect(torque, "\"" + formula + "\"", "12: torque: ", what);
  };

  expect_torque("-level*tanh(shar)", "column 13 of");
  expect_torque("-level*tanh(shar)", "unknown name 'shar', did you mean 'share'?; allowed: level");
  expect_torque("-level*tanh(share", "column 18 of");
  expect_torque("-level*tanh(share))", "unexpected parenthesis");
  expect_torque("-level**share", "column 8 of");
  expect_torque("level = 2", "'=' assigns, == compares");
  expect_torque("level, share", "',' outside of a function");
  expect_torque("level + 0.1", "adds, compares or takes functions of values of different units");
  expect_torque("level*sin(qd)", "values of different units (their time parts)");
  expect_torque("level*qd", "is in W; allowed: N m");
  expect_torque("level*share + level*current", "values of different units");

  expect("nominal: 0, ", "", "6: parameters.level", "nominal");
  expect("bounds: [0, 1]", "bounds: [1, 0]", "6: parameters.level.bounds", "the lower one first");
  expect("nominal: 0,", "nominal: 2,", "6: parameters.level.nominal", "within the bounds [0, 1]");
  expect("scale: 0.1", "scale: 0", "6: parameters.level.scale", "more than 0");
  expect("scale: 0.1", "scale: 3", "6: parameters.level.scale", "leaves the bounds");
  expect("unit: N m", "unit: Nm", "6: parameters.level.unit", "a unit of SI such as N m/rad");
  expect("unit: rad/s", "unit: rpm", "7: parameters.rate.unit", "allowed: rad/s");
  expect("  rate:", "  tau:", "7: parameters.tau", "what formulas read of the robot");
  expect("  rate:", "  sin:", "7: parameters.sin", "a function");
  expect("  rate:", "  idle: {unit: N m, nominal: 0, bounds: [0, 1], scale: 0.1}\n  rate:",
         "7: parameters.idle", "no formula has it");
  expect("  x:", "  level:", "11: states.level", "something in this file");
  expect("initial: 0", "initial: qd", "11: states.x.initial", "not known yet");
  expect("derivative", "rate", "11: states.x: unknown key", "derivative");
  expect("name: sticky", "name: payload", "2: name", "an effect of jaculus");
  expect("name: sticky", "name: Sticky!", "2: name", "lower-case letters");
  expect("{joint: elbow}", "{}", "4: at", "one place is needed");
  expect("{joint: elbow}", "{group: arms}", "4: at.group", "tail");
  expect("torque:", "moment:", "12: moment", "doesn't act at this place; allowed: torque at");
  expect("jaculus-effect/1", "jaculus-effect/7", "1: format", "allowed: jaculus-effect/1");
}

TEST(UserEffect, ThatActsAtNominalIsRefused) {
  const std::string message =
      refusal(with_line("\"-level*tanh(share)*(1 + x)\"", "\"-(level + stuck)*tanh(share)\"") +
              "constants: {stuck: {unit: N m, value: 0.2}}\n");
  EXPECT_TRUE(holds(message, "sticky.yaml:12: torque: "));
  EXPECT_TRUE(holds(message, "at nominal parameters (qd = "));
  EXPECT_TRUE(holds(message, "allowed: 0, for at nominal an effect does nothing"));
}

TEST(UserEffect, WhatActsBeforeTheMotorsMayNotReadThem) {
  const std::string message = refusal(with_line("torque: \"-level*tanh(share)*(1 + x)\"",
                                                "torque_scale: \"1 - level*hot/(1 + hot)/1\"") +
                                      "constants: {one: {unit: N m, value: 1}}\n");
  EXPECT_TRUE(holds(message, "unknown name 'hot'"));
  const std::string motors = refusal(
      with_line("torque: \"-level*tanh(share)*(1 + x)\"", "torque_scale: \"1 - level*tau*x/one\"") +
      "constants: {one: {unit: (N m)^2, value: 1}}\n");
  EXPECT_TRUE(holds(motors, "'tau' follows from what this changes"));
}

/// An effect of a text, read.
UserEffect read_text(const std::string& at, const std::string& rest) {
  const test::TemporaryFolder folder;
  return read_user_effect(
      folder.write("own.yaml", "format: jaculus-effect/1\nname: own\ncaption: own\nat: " + at +
                                   "\nparameters: {p: {unit: \"-\", nominal: 0, bounds: [0, 1], "
                                   "scale: 0.5}}\n" +
                                   rest));
}

TEST(UserEffect, ChangesADelayAReadingOrTheGroundsFriction) {
  const model::PlanarModel model = robot("minitaur_tail");
  Plant plant = simulation::nominal_plant(model);
  const Vector half = Vector::Constant(1, 0.5);
  const UserEffect delay =
      read_text("{part: commands}", "constants: {s: {unit: s, value: 8 ms}}\ndelay: p*s\n");
  delay.effect.apply(half, plant);
  EXPECT_EQ(plant.actuation.delay, 4e-3);
  EXPECT_EQ(delay.effect.where, std::vector<Component>{Component::actuation});

  const UserEffect sensor =
      read_text("{sensor: x}", "constants: {c: {unit: m/s, value: 1}}\nreading: value + p*c*t\n");
  sensor.require(model);
  sensor.effect.apply(half, plant);
  EXPECT_EQ(plant.sensing.laws.at("x")(2.0, 3.0), 3.5);
  sensor.effect.apply(half, plant);
  EXPECT_EQ(plant.sensing.laws.at("x")(2.0, 3.0), 5.0);  // one after the other
  EXPECT_EQ(sensor.effect.where, std::vector<Component>{Component::sensing});

  const UserEffect ground = read_text("{part: ground}", "friction_scale: 1 - p\n");
  ground.require(model);
  ground.effect.apply(half, plant);
  ASSERT_EQ(plant.laws.size(), 1u);
  EXPECT_EQ(plant.laws[0].actions[0].kind, ActionKind::friction_scale);
  EXPECT_EQ(ground.effect.where, std::vector<Component>{Component::contact});
}

TEST(UserEffect, OfSensorsAndPartsIsRefusedWhereItCannotBe) {
  const auto told = [](const std::string& at, const std::string& rest) {
    return test::input_error_of([&] { (void)read_text(at, rest); });
  };
  EXPECT_TRUE(holds(told("{part: commands}", "delay: p\n"), "delay: \"p\" is in -; allowed: s"));
  EXPECT_TRUE(holds(told("{part: commands}", "delay: t\n"), "not known yet: 't'"));
  EXPECT_TRUE(holds(told("{part: ground}", "torque: p\n"), "doesn't act at this place"));
  EXPECT_TRUE(holds(told("{part: ground}", "friction_scale: p\n"), "allowed: 1, for at nominal"));
  EXPECT_TRUE(holds(told("{sensor: x}", "reading: value*1.1\n"), "allowed: value, for at nominal"));
  EXPECT_TRUE(holds(told("{sensor: x}", "reading: value + p*q\n"), "unknown name 'q'"));
  EXPECT_TRUE(holds(told("{joint: elbow}", "delay: p\n"), "doesn't act at this place"));
  EXPECT_TRUE(holds(told("{part: roof}", "delay: p\n"), "ground"));

  const UserEffect metres = read_text("{sensor: elbow}", "reading: value*(1 + p)\n");
  metres.require(robot("double_pendulum"));
  EXPECT_TRUE(holds(test::input_error_of([&] { metres.require(robot("ak80_pendulum")); }),
                    "the robot has no channel 'elbow'"));
  const UserEffect battery = read_text(
      "{part: battery}", "constants: {v: {unit: V, value: 1}}\nbus_drop: p*v*tanh(abs(t)*0)\n");
  EXPECT_TRUE(holds(test::input_error_of([&] { battery.require(robot("ak80_pendulum")); }),
                    "no motor that takes a voltage"));
}

/// What a robot says of a file.
std::string misfit(const std::string& text, const std::string& name) {
  const test::TemporaryFolder folder;
  const UserEffect user = read_user_effect(folder.write("sticky.yaml", text));
  return test::input_error_of([&] { user.require(robot(name)); });
}

TEST(UserEffect, RobotsThatCannotHaveItSayWhy) {
  EXPECT_TRUE(holds(misfit(kSound, "ak80_pendulum"),
                    "sticky.yaml:4: at: the robot has no joint 'elbow'; allowed: pendulum"));
  EXPECT_TRUE(holds(misfit(with_line("{joint: elbow}", "{group: tail}"), "ak80_pendulum"),
                    "no joint with a motor in the group 'tail'"));
  EXPECT_TRUE(holds(misfit(with_line("{joint: elbow}", "{joint: slide}"), "slider"),
                    "'slide' slides; allowed there: force, in N"));
  EXPECT_TRUE(holds(misfit(with_line("(1 + x)", "(1 + x*shoulders.q)"), "double_pendulum"),
                    "the robot has no joint 'shoulders', did you mean 'shoulder'?"));
  const std::string electric = with_line("(1 + x)", "(1 + x*current/(abs(current) + 0*current))");
  EXPECT_TRUE(holds(misfit(with_line("{joint: elbow}", "{joint: pendulum}"), "double_pendulum"),
                    "the robot has no joint 'pendulum'"));
  std::string ideal = electric;
  ideal.replace(ideal.find("{joint: elbow}"), 14, "{joint: pendulum}");
  EXPECT_TRUE(holds(misfit(ideal, "ak80_pendulum"), "an ideal one without current"));
}

TEST(UserEffect, ReadsTheLimitOfAMotorThatHasOne) {
  const test::TemporaryFolder folder;
  const UserEffect user =
      read_user_effect(folder.write("sticky.yaml", with_line("(1 + x)", "(1 + x*tau/tau_limit)")));
  model::PlanarModel two = robot("double_pendulum");
  EXPECT_NO_THROW(user.require(two));

  model::PlanarMotor& elbow = two.motors[two.motor_index("elbow")];
  elbow.torque_limit = elbow.current_limit = kInfinity;
  EXPECT_TRUE(holds(test::input_error_of([&] { user.require(two); }),
                    "the motor of 'elbow' has no limit of torque or current for tau_limit"));
}

TEST(UserEffect, OfAGroupIsAlsoThatOfEachJoint) {
  const test::TemporaryFolder folder;
  const auto entries = [&](const std::string& at, const std::string& name) {
    const UserEffect user =
        read_user_effect(folder.write("sticky.yaml", with_line("{joint: elbow}", at)));
    return sized_for(user.effect, robot(name), {});
  };
  const std::vector<Effect> other = entries("{group: other}", "double_pendulum");
  ASSERT_EQ(other.size(), 3u);
  EXPECT_EQ(other[0].name, "sticky");
  EXPECT_EQ(other[2].name, "sticky@elbow");
  Plant plant = simulation::nominal_plant(robot("double_pendulum"));
  other[0].apply(other[0].probed(), plant);
  ASSERT_EQ(plant.laws.size(), 2u);
  EXPECT_EQ(plant.laws[1].actions.front().of, "elbow");

  const std::vector<Effect> legs = entries("{group: legs}", "minitaur_tail");
  ASSERT_EQ(legs.size(), 1u);
  EXPECT_EQ(in_parts(legs[0]).size(), 2u);
  EXPECT_TRUE(legs[0].acts_in(Component::front_legs));
  const std::vector<Effect> tail = entries("{joint: tail}", "minitaur_tail");
  EXPECT_EQ(tail[0].where, std::vector<Component>{Component::tail_transmission});
}

TEST(UserEffect, IsFoundInACatalogueByItsName) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("sticky.yaml", kSound);
  const model::PlanarModel model = robot("double_pendulum");
  const Catalogue catalogue = catalogue_with({file}, {model});
  ASSERT_EQ(catalogue.size(), effect_catalogue().size() + 1);
  const EffectValue value = read_effect("sticky:level=0.3", model, "--effect", catalogue);
  EXPECT_EQ(value.theta[0], 0.3);
  EXPECT_EQ(value.theta[1], 1.0);
  EXPECT_TRUE(
      holds(test::input_error_of([&] { (void)read_effect("sticky:level=0.3", model, "--effect"); }),
            "unknown effect 'sticky'"));
  EXPECT_TRUE(holds(test::input_error_of([&] {
                      (void)catalogue_with({file, file}, {model});
                    }),
                    "another file has an effect 'sticky' too"));
}

// The examples
// -------------------------------------------------------------------------------------------------

std::vector<std::string> examples() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(source_folder() / "effects"))
    names.push_back(entry.path().stem());
  std::sort(names.begin(), names.end());
  return names;
}

class EveryExample : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryExample, PassesTheChecks) {
  const UserEffect user = read_user_effect(source_folder() / "effects" / (GetParam() + ".yaml"));
  const simulation::Experiment experiment = simulation::read_experiment(user.experiment);
  user.require(simulation::dataset_robot(experiment.setup).planar);
  const std::vector<Check> checks = check_effect(user.effect, experiment);
  EXPECT_GE(checks.size(), 5u);
  for (const Check& check : checks) EXPECT_TRUE(check.passed) << check.what << ": " << check.found;
}

INSTANTIATE_TEST_SUITE_P(Effects, EveryExample, ::testing::ValuesIn(examples()),
                         [](const auto& info) { return info.param; });

/// A check that must fail where there is something to find.
TEST(Check, OfAnEffectThatJumpsFails) {
  const UserEffect user = read_user_effect(source_folder() / "effects" / "cogging.yaml");
  const simulation::Experiment experiment = simulation::read_experiment(user.experiment);
  Effect jumps = user.effect;
  jumps.apply = [inner = user.effect.apply, full = user.effect.probed()](const Vector& theta,
                                                                         Plant& plant) {
    if (theta[0] != 0.0) inner(full, plant);
  };
  const std::vector<Check> checks = check_effect(jumps, experiment);
  ASSERT_GE(checks.size(), 3u);
  EXPECT_TRUE(checks[0].passed);
  EXPECT_FALSE(checks[1].passed) << checks[1].found;

  Effect at_nominal = user.effect;
  at_nominal.apply = [inner = user.effect.apply, full = user.effect.probed()](
                         const Vector&, Plant& plant) { inner(full, plant); };
  EXPECT_FALSE(check_effect(at_nominal, experiment).front().passed);
}

}  // namespace
}  // namespace jaculus::effects
