#include "jaculus/trajectory/leap_accelerations.h"

namespace jaculus::trajectory {

std::optional<LeapAccelerations> leap_accelerations(const Dataset& dataset) {
  if (dataset.experiment != ExperimentKind::leap || !dataset.plan) return std::nullopt;
  const Table& plan = *dataset.plan;
  const Eigen::Index end = plan.values.rows() - 1;
  LeapAccelerations all;
  all.duration = plan.values(end, plan.column("time"));
  if (const int v = plan.column("x_velocity"); v >= 0)
    all.plan = plan.values(end, v) / all.duration;

  double sum = 0.0;
  int count = 0;
  for (const Trial& trial : dataset.trials) {
    const Stream* mocap = trial.stream(kMocapStream);
    if (mocap == nullptr || mocap->channel("x") < 0) continue;
    const int y = mocap->channel("y");
    const auto found =
        leap_speed(mocap->time, mocap->values.row(mocap->channel("x")).transpose(),
                   y < 0 ? Vector() : Vector(mocap->values.row(y).transpose()), all.duration);
    all.trials.push_back({trial.name, found});
    if (!found) continue;
    sum += found->acceleration;
    ++count;
  }

  if (all.trials.empty()) return std::nullopt;
  if (count > 0) all.mean = sum / count;
  return all;
}

}  // namespace jaculus::trajectory
