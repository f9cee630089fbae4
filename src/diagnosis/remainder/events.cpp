#include "diagnosis/remainder/events.h"

#include <algorithm>
#include <tuple>

#include "diagnosis/remainder/pulses.h"

namespace jaculus::diagnosis {
namespace {

/// Boxes for each function of the motion that missing forces may follow.
constexpr Eigen::Index kBoxesAFunction = 10;

/// Forces along a coordinate. They may follow friction at it (rate and sign) and the weights of all
/// bodies (sines and cosines of their angles), and are wrong by more where anything moves fast or
/// is accelerated hard.
ForceBoxes forces_along(const std::vector<MotionBox>& boxes, double length, int coordinate) {
  const Eigen::Index n = boxes.front().force.size(), angles = boxes.front().angles.size();
  const auto count = std::ssize(boxes);
  ForceBoxes along;
  along.length = length;
  along.time.resize(count);
  along.force.resize(count);
  along.follows = Matrix::Ones(count, count < kBoxesAFunction * (3 + angles) ? 1 : 3 + angles);
  along.spreads = Matrix::Ones(count, 1 + 2 * n);

  for (Eigen::Index k = 0; k < count; ++k) {
    const MotionBox& box = boxes[k];
    along.trial.push_back(box.trial);
    along.time[k] = box.start + 0.5 * length;
    along.force[k] = box.force[coordinate];
    along.spreads.row(k).segment(1, n) = box.mean_rate.cwiseAbs2();
    along.spreads.row(k).segment(1 + n, n) = box.acceleration.cwiseAbs2();
    if (along.follows.cols() == 1) continue;
    along.follows(k, 1) = box.mean_rate[coordinate];
    along.follows(k, 2) = box.mean_sign[coordinate];
    along.follows.row(k).tail(angles) = box.angles;
  }
  return along;
}

}  // namespace

std::vector<ForceEvent> force_events(const Problem& all,
                                     const std::vector<std::vector<MotionBox>>& boxes_by_dataset) {
  std::vector<ForceEvent> events;
  const double length = all.settings.window_length;
  for (int d = 0; d < count_of(all.observations.datasets); ++d) {
    const ObservedDataset& observed = all.observations.datasets[d];
    const std::vector<MotionBox>& boxes = boxes_by_dataset[d];
    if (boxes.empty()) continue;
    for (int i = 0; i < observed.model.size(); ++i) {
      const model::Coordinate& coordinate = observed.model.coordinates[i];
      const ForceBoxes along = forces_along(boxes, length, i);
      for (const Pulse& pulse : unusual_pulses(along, all.settings.event_level)) {
        ForceEvent event;
        event.dataset = d;
        event.trial = observed.dataset.trials[along.trial[pulse.first]].name;
        event.joint = coordinate.name;
        event.from = along.time[pulse.first] - 0.5 * length;
        event.to = along.time[pulse.last] + 0.5 * length;
        event.peak = pulse.peak;
        event.unit = coordinate.angular ? "N m" : "N";
        event.probability = pulse.probability;
        event.every_trial = pulse.every_trial;
        events.push_back(event);
      }
    }
  }

  std::stable_sort(events.begin(), events.end(), [](const ForceEvent& a, const ForceEvent& b) {
    return std::tie(a.dataset, a.trial, a.from) < std::tie(b.dataset, b.trial, b.from);
  });
  return events;
}

}  // namespace jaculus::diagnosis
