// A healthy robot at rest when its log begins.

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/effects_by_name.h"
#include "jaculus/core/installation.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::diagnosis {
namespace {

TEST(LoggedFriction, OfAHealthyRobotAtRestIsNone) {
  // Windows that began at the log's first sample took its rate from one side alone, and dry
  // friction within tolerance was behind something unknown by 219 nats, at 1.4 noise floors.
  testbed::TrialSpec spec;
  spec.trials = 4;
  spec.seed = 21;
  spec.clutter_seed = 21;
  spec.sensors.torque = true;
  const trajectory::Dataset data =
      testbed::run_trials(testbed::swing(source_folder() / "models" / "double_pendulum",
                                         *testbed::swing_inputs().find("logged_torque")),
                          {}, spec);
  const Diagnosis d = diagnose({data}, test::among({"joint_backlash"}));

  const auto log_evidence = [&](const std::string& name) {
    const auto row = std::find_if(d.ranking.begin(), d.ranking.end(),
                                  [&](const Ranked& r) { return r.effect == name; });
    return row->log_evidence;
  };
  EXPECT_EQ(d.verdict, Verdict::none);
  EXPECT_LT(d.gap.adjusted, 1.2);
  EXPECT_GT(log_evidence("none") - log_evidence("unexplained"), -3.0);
}

}  // namespace
}  // namespace jaculus::diagnosis
