// A healthy robot whose legs part where one foot leaves the floor before the other.

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "diagnosis/effects_by_name.h"
#include "jaculus/core/installation.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/diagnosis_json.h"
#include "jaculus/diagnosis/summary.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::diagnosis {
namespace {

TEST(PartedRobot, IsNoneUpToWhereItsLegsPartAndSaidToBeSo) {
  // Without the cut this robot was `unexplained`, at 4 noise floors and 205 nats.
  const auto source = source_folder();
  testbed::TrialSpec spec;
  spec.trials = 4;
  spec.seed = 21;
  spec.clutter_seed = 21;
  const trajectory::Dataset data = testbed::run_trials(
      testbed::leap(source / "models" / "minitaur_tail", source / "problems" / "leap_tail_plan.csv",
                    trajectory::Quantity::torque),
      {}, spec);
  const Diagnosis d = diagnose({data}, test::among({"leg_offset", "foot_friction"}));

  EXPECT_EQ(d.verdict, Verdict::none);
  EXPECT_LT(d.gap.adjusted, 1.2);
  ASSERT_EQ(d.partings.size(), data.trials.size());
  for (const Parting& parting : d.partings) {
    EXPECT_EQ(parting.joint, "rear_b");
    EXPECT_NEAR(parting.from, 0.11, 0.01);
    EXPECT_GT(parting.most, 0.2);
  }
  const auto holds = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(
      holds(summary_of(d).where, "Left and right part in 4 of 4 trials, first at rear b 0.1"));
  const auto json = nlohmann::json::parse(diagnosis_json(d));
  EXPECT_FALSE(json["remainder"]["established"].get<bool>());
  EXPECT_EQ(json["remainder"]["partings"].size(), data.trials.size());
  EXPECT_TRUE(std::any_of(d.notes.begin(), d.notes.end(), [&](const std::string& note) {
    return holds(note, "left and right part in 4 of 4 trials");
  }));
}

}  // namespace
}  // namespace jaculus::diagnosis
