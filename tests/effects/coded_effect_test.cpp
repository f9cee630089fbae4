// Effects whose forces a program computes, beside the same ones in files.

#include "jaculus/effects/coded_effect.h"

#include <gtest/gtest.h>

#include "jaculus/core/installation.h"
#include "jaculus/effects/select.h"
#include "jaculus/model/robot.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::effects {
namespace {

using simulation::LawFunctions;
using simulation::Plant;
using test::holds;

model::PlanarModel double_pendulum() {
  return model::read_robot(source_folder() / "models/double_pendulum").planar;
}

std::string declared(const std::string& at = "{joint: elbow}") {
  return "format: jaculus-effect/1\nname: sticky\ncaption: something sticky\nat: " + at +
         "\nparameters:\n"
         "  level: {unit: N m, nominal: 0, bounds: [0, 1], scale: 0.1}\n"
         "  lag: {unit: s, nominal: 0.1, bounds: [0.01, 1], scale: 0.1}\n";
}

yaml::Node node(const std::string& text) { return yaml::Node::parse(text, "own"); }

/// torque: -level w, w' = (qd - w)/lag; `offset` acts at nominal too.
EffectCode sticky(double offset = 0.0) {
  return {{"qd"}, {"torque"}, [offset](const Vector& theta) {
            LawFunctions functions;
            functions.act = [theta, offset](const double* readings, const double* states,
                                            double* actions, double* rates) {
              actions[0] = -theta[0] * states[0] + offset;
              rates[0] = (readings[0] - states[0]) / theta[1];
            };
            return functions;
          }};
}

const char* const kState = "states: {w: {unit: rad/s, initial: 2, scale: 3}}\n";

TEST(CodedEffect, IsThatOfTheSameFormulas) {
  const test::TemporaryFolder folder;
  const UserEffect coded = coded_effect(node(declared() + kState), sticky());
  const UserEffect written = read_user_effect(folder.write(
      "sticky.yaml",
      declared() + "constants: {one: {unit: 1/(rad/s), value: 1}, two: {unit: rad/s, value: 2}}\n"
                   "states: {w: {unit: rad/s, initial: two, derivative: (qd - w)/lag, scale: 3}}\n"
                   "torque: -level*w*one\n"));
  EXPECT_TRUE(effect_faults(coded.effect).empty());
  EXPECT_EQ(coded.effect.file, "");
  EXPECT_EQ(coded.effect.where, written.effect.where);

  const Vector theta{{0.3, 0.2}};
  std::vector<double> results[2];
  for (const UserEffect* user : {&coded, &written}) {
    Plant plant = simulation::nominal_plant(double_pendulum());
    user->require(plant.model);
    user->effect.apply(theta, plant);
    ASSERT_EQ(plant.laws.size(), 1u);
    const simulation::Law& law = plant.laws.front();
    ASSERT_EQ(law.states.size(), 1u);
    EXPECT_EQ(law.states[0].scale, 3.0);
    EXPECT_EQ(law.actions.front().of, "elbow");
    const double reading = 1.5, state = law.states[0].initial;
    double action = 0.0, rate = 0.0;
    law.functions().act(&reading, &state, &action, &rate);
    results[user == &written] = {state, action, rate};
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], (std::vector<double>{2.0, -0.6, -2.5}));
}

TEST(CodedEffect, IsInACatalogueOnce) {
  const UserEffect coded = coded_effect(node(declared() + kState), sticky());
  const model::PlanarModel model = double_pendulum();
  const Catalogue catalogue = catalogue_with({}, {model}, {coded});
  EXPECT_EQ(read_effect("sticky:level=0.3", model, "here", catalogue).theta[0], 0.3);
  EXPECT_TRUE(holds(test::input_error_of([&] {
                      (void)catalogue_with({}, {model}, {coded, coded});
                    }),
                    "another one has an effect 'sticky' too"));
}

TEST(CodedEffect, FaultsAreTold) {
  const auto told = [](const std::string& text, const EffectCode& code) {
    return test::input_error_of([&] { (void)coded_effect(node(text), code); });
  };
  EffectCode code = sticky();
  code.reads = {"speed"};
  EXPECT_TRUE(holds(told(declared() + kState, code), "unknown name 'speed'; allowed: parameters"));
  code = sticky();
  code.actions = {"moment"};
  EXPECT_TRUE(holds(told(declared() + kState, code), "moment: doesn't act at this place"));
  code.actions = {};
  EXPECT_TRUE(holds(told(declared() + kState, code), "does nothing"));
  code.actions = {"torque_scale"};
  code.reads = {"tau"};
  EXPECT_TRUE(holds(told(declared() + kState, code), "'tau' follows from what this changes"));
  EXPECT_TRUE(
      holds(told(declared() + kState, sticky(0.2)), "torque is 0.2 at nominal parameters (qd = "));
  EXPECT_TRUE(holds(told(declared() + "torque: 2\n", sticky()), "unknown key"));
}

}  // namespace
}  // namespace jaculus::effects
