// A plan replayed on the testbed's robot, without noise: the base's speed from its own motion
// capture.

#include <cmath>
#include <filesystem>

#include "evaluation/scratch_folder.h"
#include "jaculus/core/error.h"
#include "jaculus/evaluation/replan.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::evaluation {
namespace {

/// Slope at `time` of the parabola through the three samples about it [1/s].
double slope_at(const Vector& t, const Eigen::RowVectorXd& y, double time) {
  Eigen::Index k = 1;
  while (k + 2 < t.size() && t[k + 1] < time) ++k;
  const double a = (y[k] - y[k - 1]) / (t[k] - t[k - 1]), b = (y[k + 1] - y[k]) / (t[k + 1] - t[k]);
  const double curvature = (b - a) / (t[k + 1] - t[k - 1]);
  return a + curvature * (2.0 * time - t[k - 1] - t[k]);
}

}  // namespace

PlanReplay replay_on_testbed(const std::filesystem::path& folder, const testbed::Changes& changes) {
  if (!testbed::available())
    throw InputError("replan on the testbed: this build was made without MuJoCo");

  // What the robot does, not what motion capture makes of it.
  testbed::Changes truth = changes;
  for (const char* channel : {"x", "z", "pitch"}) truth.scale.erase(channel);
  truth.latency.erase(trajectory::kMocapStream);
  truth.tracked_point.setZero();
  truth.mocap_tilt = 0.0;

  return [folder, truth](const trajectory::Table& plan) {
    const evaluation::ScratchFolder scratch("jaculus_plan_");
    const std::filesystem::path file = scratch.path / "plan.csv";
    trajectory::write_csv(plan, file);
    testbed::TrialSpec spec;
    spec.trials = 1;
    spec.exact = true;
    spec.sensors.mocap_rate_hz = 2000.0;
    const trajectory::Dataset played =
        testbed::run_trials(testbed::leap(folder, file, trajectory::Quantity::torque), truth, spec);
    const trajectory::Stream* mocap = played.trials.front().stream(trajectory::kMocapStream);
    const int x = mocap == nullptr ? -1 : mocap->channel("x");
    const int time = plan.column("time");
    const double end = plan.values(plan.values.rows() - 1, time);
    if (x < 0 || mocap->time[mocap->time.size() - 1] < end) return kNaN;
    return slope_at(mocap->time, mocap->values.row(x), end);
  };
}

}  // namespace jaculus::evaluation
