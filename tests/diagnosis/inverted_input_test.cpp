// Logs whose units or signs can't be, before any effect is looked for.

#include <gtest/gtest.h>

#include "diagnosis/logged_trials.h"
#include "jaculus/core/error.h"
#include "jaculus/diagnosis/diagnose.h"

namespace jaculus::diagnosis {
namespace {

/// A few trials of a pendulum, heavier than its file says and with friction.
trajectory::Dataset pendulum() {
  return test::logged("pendulum_trials.yaml", {},
                      {"joint_coulomb_friction:torque=0.05", "link_mass:scale=1.1"}, 3, 4);
}

/// The values of each channel whose name ends so, times a factor.
trajectory::Dataset times(trajectory::Dataset dataset, const std::string& ending, double factor) {
  for (trajectory::Trial& trial : dataset.trials)
    for (trajectory::Stream& stream : trial.streams)
      for (std::size_t c = 0; c < stream.channels.size(); ++c)
        if (stream.channels[c].ends_with(ending))
          stream.values.row(static_cast<Eigen::Index>(c)) *= factor;
  return dataset;
}

Diagnosis diagnosed_pendulum(const trajectory::Dataset& dataset) {
  DiagnoseOptions options;
  options.effects = {effects::find_effect("joint_coulomb_friction"),
                     effects::find_effect("link_mass")};
  return diagnose({dataset}, options);
}

TEST(InvertedInput, IsNamedAndNothingElse) {
  const Diagnosis found = diagnosed_pendulum(times(pendulum(), "_torque", -1.0));
  EXPECT_EQ(found.verdict, Verdict::insufficient);
  ASSERT_EQ(found.reasons.size(), 1u);
  EXPECT_NE(found.reasons[0].find("looks inverted"), std::string::npos) << found.reasons[0];
  EXPECT_TRUE(found.effects.empty());
}

TEST(InvertedInput, IsNotSeenInALogThatIsRight) {
  const Diagnosis found = diagnosed_pendulum(pendulum());
  EXPECT_NE(found.verdict, Verdict::insufficient);
}

TEST(Units, OfWhatSlidesAreRefusedForAJointThatTurns) {
  trajectory::Dataset dataset = pendulum();
  for (trajectory::Trial& trial : dataset.trials)
    for (trajectory::Stream& stream : trial.streams)
      if (const int c = stream.channel("pendulum"); c >= 0) stream.units[c] = "m";
  try {
    (void)diagnosed_pendulum(dataset);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("is in m, but the joint turns; allowed: rad"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
