// An encoder that is off, where its own log drives the model.

#include <gtest/gtest.h>

#include "diagnosis/effects_by_name.h"
#include "diagnosis/logged_trials.h"
#include "jaculus/diagnosis/diagnose.h"

namespace jaculus::diagnosis {
namespace {

TEST(LoggedOffset, IsFoundByTheWeightThatPullsOtherwise) {
  // Windows begin where encoders say. As if these were right, a shoulder that reads 0.03 rad too
  // much was taken for one of 0.006 rad and something unknown.
  const trajectory::Dataset dataset =
      test::logged("double_pendulum_trials.yaml", {}, {"joint_offset@shoulder:offset=0.03"}, 3, 5);
  const DiagnoseOptions options = test::among({"joint_offset", "joint_coulomb_friction"});
  const Diagnosis d = diagnose({dataset}, options);
  EXPECT_EQ(d.verdict, Verdict::effect) << to_text(d.verdict);
  ASSERT_EQ(d.effects.size(), 1U);
  EXPECT_EQ(d.effects[0].name, "joint_offset@shoulder");
  const auto& found = d.effects[0].parameters.front();
  EXPECT_NEAR(found.value, 0.03, 6e-3) << "an encoder's zero is known to 3 mrad";
  EXPECT_TRUE(found.ci95.contains(0.03)) << found.ci95.lower << " to " << found.ci95.upper;
}

}  // namespace
}  // namespace jaculus::diagnosis
