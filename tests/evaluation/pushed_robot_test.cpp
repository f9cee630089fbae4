// Forces that acted once, in the log of a robot that was pushed.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "diagnosis/build_problem.h"
#include "diagnosis/remainder/events.h"
#include "jaculus/evaluation/real.h"
#include "jaculus/trajectory/dataset.h"
#include "model/support.h"

namespace jaculus::test {
namespace {

using diagnosis::ForceEvent;

/// Whether an event is a push: joint, trial, sign, middle within 0.1 s, peak within 30 %.
bool tells(const ForceEvent& event, const evaluation::KnownEvent& push) {
  const double apart = 0.5 * std::abs(event.from + event.to - push.from - push.to);
  return event.joint == push.joint && event.trial == push.trial && apart <= 0.1 &&
         std::abs(event.peak - push.peak) <= 0.3 * std::abs(push.peak);
}

/// DFKI's acrobot, with torques of 0.5 to 0.75 N m added to its motors' commands that its log does
/// not state. Friction and rotors are those that a diagnosis of the robot finds.
TEST(Events, OfAPushedRobotAreItsPushes) {
  const std::filesystem::path folder = testing::data_folder() / "double_pendulum/acrobot_pushed";
  if (testing::data_folder().empty()) {
    ASSERT_EQ(std::getenv("CI"), nullptr) << "the real data must be there: set JACULUS_DATA";
    GTEST_SKIP() << "no real data: set JACULUS_DATA or put it in ../shared/data";
  }
  const auto known = evaluation::known_cause_of(folder);
  ASSERT_TRUE(known.has_value());

  diagnosis::DiagnoseOptions options;
  for (const effects::Effect& effect : effects::effect_catalogue())
    if (effect.name == "joint_coulomb_friction" || effect.name == "joint_rotor_inertia")
      options.effects.push_back(&effect);
  options.settings.windows = 1'000'000;
  options.settings.window_length = options.settings.force_box;
  options.settings.window_start_half_width = 0.5 * options.settings.force_box;
  const diagnosis::BuiltProblem all =
      diagnosis::build_problem({trajectory::read_dataset(folder)}, options);
  ASSERT_TRUE(all.forward.has_value());
  Vector p = all.problem->hypotheses.nominal();
  for (int i = 0; i < p.size(); ++i) {
    const std::string& owner = all.problem->hypotheses.parameters[i].owner;
    if (owner == "joint_coulomb_friction") p[i] = 0.17;  // [N m]
    if (owner == "joint_rotor_inertia") p[i] = 0.005;    // [kg m^2]
  }

  const std::vector<ForceEvent> events =
      force_events(*all.problem, motion_boxes(*all.problem, *all.forward, p));
  int pushes = 0;
  for (const evaluation::KnownEvent& push : known->events)
    pushes += std::any_of(events.begin(), events.end(),
                          [&](const ForceEvent& event) { return tells(event, push); });
  EXPECT_GE(pushes, 0.8 * static_cast<double>(known->events.size()));
  EXPECT_LE(std::ssize(events) - pushes, 4) << "more than one a trial that was no push";
}

}  // namespace
}  // namespace jaculus::test
