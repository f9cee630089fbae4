// Which effects the MuJoCo robot can't tell apart, by what follows from their definitions.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "jaculus/core/installation.h"
#include "testbed/draws.h"

namespace jaculus::testbed {
namespace {

namespace fs = std::filesystem;

/// The shipped plan replayed by torque, with the signatures of a few effects.
struct Bench {
  Stage stage;
  Signatures signatures;
};

Bench bench(const std::vector<std::string>& effects) {
  const fs::path source = source_folder();
  Bench out;
  out.stage = make_stage(
      "leap", leap(source / "models" / "minitaur_tail", source / "problems" / "leap_tail_plan.csv",
                   trajectory::Quantity::torque));
  std::vector<std::string> bytes;
  for (const std::string& name : signature_effects(out.stage)) {
    const bool wanted = std::find(effects.begin(), effects.end(), name) != effects.end();
    bytes.push_back(wanted ? signature_bytes(out.stage, name) : "");
  }
  out.signatures = signatures_of(out.stage, bytes);
  return out;
}

std::vector<std::string> passing_for(const Bench& on, const std::string& effect, double strength,
                                     bool electric) {
  TrialSpec spec;
  spec.sensors.electric = electric;
  const BenchEffect& truth = *find_bench_effect(on.stage.effects, effect);
  Dose dose{&truth, usual_values(truth)};
  dose.values[0] = strength;
  return equivalents(on.stage, on.signatures, spec, *exact_run(on.stage, Changes{}, spec), dose);
}

using Names = std::vector<std::string>;

// A late command is the command of a later clock: u(t + d) = feed-forward(t) + K (reference(t) -
// q(t)), and with q'(t) = q(t + d) u'(t) = feed-forward(t) + K (reference(t) - q'(t - d)), a sensor
// that is late by d and stamps so.
TEST(Equivalence, CommandsThatAreLatePassForSensorsThatAre) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const Bench on = bench({"actuation_delay", "sensor_latency", "payload"});
  EXPECT_EQ(passing_for(on, "actuation_delay", 0.003, true), Names{"sensor_latency"});
}

// By torque a motor's constant alone scales what it gives, warm or weak; its voltage tells warmth,
// as R rises too.
TEST(Equivalence, WarmWindingsPassForWeakMagnetsUntilTheDutyIsLogged) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const Bench on = bench({"winding_heating", "torque_constant", "payload"});
  EXPECT_EQ(passing_for(on, "winding_heating", 5.0, false), Names{"torque_constant"});
  EXPECT_EQ(passing_for(on, "winding_heating", 5.0, true), Names{});
}

}  // namespace
}  // namespace jaculus::testbed
