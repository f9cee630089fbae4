// The clock of motion capture where nothing else was logged: no robot's latency.

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/effects_by_name.h"
#include "jaculus/core/installation.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/effects/select.h"
#include "jaculus/effects/trials.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::test {
namespace {

constexpr double kLate = 0.012;  // [s], six times what a stamp may be late otherwise

/// A healthy robot's leaps by motion capture alone, all of whose stamps are late.
trajectory::Dataset tracked_late() {
  const simulation::Experiment played =
      simulation::read_experiment(source_folder() / "problems" / "leap_trials.yaml");
  trajectory::Dataset dataset =
      effects::simulate_trials(played, {}, simulation::dataset_robot(played.setup).planar).dataset;
  for (trajectory::Trial& trial : dataset.trials) {
    std::erase_if(trial.streams, [](const trajectory::Stream& s) { return s.name != "mocap"; });
    for (trajectory::Stream& stream : trial.streams) stream.time.array() += kLate;
  }
  return dataset;
}

TEST(ForeignClock, IsToldAndTakenForNoLatency) {
  const diagnosis::DiagnoseOptions options =
      among({"sensor_latency", "actuation_delay", "payload"});
  const diagnosis::Diagnosis found = diagnosis::diagnose({tracked_late()}, options);
  EXPECT_EQ(found.verdict, diagnosis::Verdict::none);

  const auto& unknowns = found.agreement.unknowns;
  const auto clock = std::find_if(unknowns.begin(), unknowns.end(),
                                  [](const auto& u) { return u.name == "clock"; });
  ASSERT_NE(clock, unknowns.end());
  EXPECT_NEAR(clock->value, 1e3 * kLate, 1.0);
  EXPECT_TRUE(clock->ci95.contains(clock->value));
}

}  // namespace
}  // namespace jaculus::test
