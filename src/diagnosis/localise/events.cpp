#include "diagnosis/localise/events.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "diagnosis/forward/missing_forces.h"
#include "diagnosis/localise/pulses.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kSameTime = 1e-6;  // [s]
constexpr int kSteps = 12;
constexpr double kForceReached = 1e-3;  ///< share of the force by which the last step moves it
/// Boxes for each function of the motion that missing forces may follow.
constexpr Eigen::Index kBoxesAFunction = 10;

/// How many equal joints a coordinate moves: a push counts for each.
int joints_of(const model::PlanarModel& robot, const std::string& coordinate) {
  const int motor = robot.motor_index(coordinate), body = robot.body_of_joint(coordinate);
  if (motor >= 0) return robot.motors[motor].count;
  return body >= 0 ? robot.bodies[body].count : 1;
}

/// Rates at the end of a window under constant forces along the coordinates; empty where it can't
/// be simulated.
Vector rates_under(const SimulationSetup& setup, const Vector& force) {
  simulation::Plant plant = setup.plant;
  for (int i = 0; i < force.size(); ++i) {
    const std::string& name = plant.model.coordinates[i].name;
    if (force[i] != 0.0)
      plant.pushes.push_back(
          box_push(name, force[i] / joints_of(plant.model, name), 0.0, setup.options.duration));
  }
  const simulation::Simulation simulated =
      simulate(plant, setup.controller, setup.start, setup.options);
  const bool done = simulated.status == simulation::SimulationStatus::done &&
                    simulated.time.size() == 2 && simulated.v.allFinite();
  return done ? Vector(simulated.v.col(1)) : Vector();
}

/// Whether a force can act along every coordinate.
bool pushable(const model::PlanarModel& robot) {
  return std::all_of(robot.coordinates.begin(), robot.coordinates.end(),
                     [&](const model::Coordinate& c) { return has_place(robot, c.name); });
}

/// The constant force along every coordinate under which a window ends with the rates measured, by
/// f <- f + M (v measured - v simulated)/h, from where least was left. Empty where nothing can be
/// simulated.
Vector force_reaching(const SimulationSetup& setup, const Matrix& mass, const Vector& rates) {
  const int steps = pushable(setup.plant.model) ? kSteps : 1;
  Vector best, force = Vector::Zero(rates.size());
  double least = kInfinity;
  for (int step = 0; step < steps; ++step) {
    const Vector reached = rates_under(setup, force);
    if (reached.size() == 0) break;
    const Vector more = mass * (rates - reached) / setup.options.duration;
    force += more;
    if (more.norm() >= least) continue;
    least = more.norm();
    best = force;
    if (least <= kForceReached * force.norm()) break;
  }
  return best;
}

/// What a box of time between the starts of two windows lacks, and its motion.
struct Box {
  int segment = 0;
  Vector force, mean_rate, mean_sign, acceleration;  ///< of each coordinate
  Vector angles;  ///< sines and cosines of the bodies' angles at its end
};

/// Mean of the sign of a rate that goes evenly from one value to another.
double mean_sign(double from, double to) {
  if (from == to) return from > 0.0 ? 1.0 : from < 0.0 ? -1.0 : 0.0;
  return (std::abs(to) - std::abs(from)) / (to - from);
}

/// None where the second window doesn't follow the first, or it can't be simulated.
std::optional<Box> box_between(const PlantForward& forward, int dataset, int segment,
                               const ObservedDataset& observed, double length, const Vector& p) {
  if (segment + 1 >= count_of(observed.segments)) return std::nullopt;
  const Segment &own = observed.segments[segment], &next = observed.segments[segment + 1];
  const double apart = next.start - own.start;
  if (next.trial != own.trial || std::abs(apart - length) > kSameTime) return std::nullopt;

  SimulationSetup setup = forward.setup(dataset, segment, p);
  setup.options.sample_times = Vector::LinSpaced(2, 0.0, apart);
  setup.options.duration = apart;
  const dynamics::AbsoluteTree tree(setup.plant.model);
  dynamics::Motion motion(tree);
  if (!set_configuration(tree, next.start_q, motion)) return std::nullopt;

  Box box;
  box.segment = segment;
  box.force = force_reaching(setup, mass_matrix(tree, motion), next.start_v);
  if (box.force.size() == 0) return std::nullopt;
  box.mean_rate = 0.5 * (own.start_v + next.start_v);
  box.mean_sign = own.start_v.binaryExpr(next.start_v, &mean_sign);
  box.acceleration = (next.start_v - own.start_v) / apart;
  const Eigen::Index bodies = count_of(setup.plant.model.bodies);
  box.angles.resize(2 * bodies);
  box.angles << motion.pose.sine.segment(tree.angle_index(0), bodies),
      motion.pose.cosine.segment(tree.angle_index(0), bodies);
  return box;
}

/// All boxes of a dataset, those of a trial in the order of time.
std::vector<Box> boxes_of(const Problem& all, const PlantForward& forward, int dataset,
                          const Vector& p) {
  const ObservedDataset& observed = all.observations.datasets[dataset];
  std::vector<std::optional<Box>> each(observed.segments.size());
  tbb::parallel_for(0, count_of(each), [&](int s) {
    each[s] = box_between(forward, dataset, s, observed, all.settings.window_length, p);
  });

  std::vector<Box> boxes;
  for (std::optional<Box>& box : each)
    if (box) boxes.push_back(std::move(*box));
  return boxes;
}

/// Forces along a coordinate. They may follow friction at it (rate and sign) and the weights of all
/// bodies (sines and cosines of their angles), and are wrong by more where anything moves fast or
/// is accelerated hard.
ForceBoxes forces_along(const std::vector<Box>& boxes, const ObservedDataset& observed,
                        double length, int coordinate) {
  const Eigen::Index n = observed.model.size(), angles = boxes.front().angles.size();
  const auto count = std::ssize(boxes);
  ForceBoxes along;
  along.length = length;
  along.time.resize(count);
  along.force.resize(count);
  along.follows = Matrix::Ones(count, count < kBoxesAFunction * (3 + angles) ? 1 : 3 + angles);
  along.spreads = Matrix::Ones(count, 1 + 2 * n);

  for (Eigen::Index k = 0; k < count; ++k) {
    const Box& box = boxes[k];
    const Segment& segment = observed.segments[box.segment];
    along.trial.push_back(segment.trial);
    along.time[k] = segment.start + 0.5 * length;
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

std::vector<ForceEvent> force_events(const Problem& all, const PlantForward& forward,
                                     const Vector& p) {
  std::vector<ForceEvent> events;
  if (!in_windows(all)) return events;
  const double length = all.settings.window_length;
  for (int d = 0; d < count_of(all.observations.datasets); ++d) {
    const ObservedDataset& observed = all.observations.datasets[d];
    const std::vector<Box> boxes = boxes_of(all, forward, d, p);
    if (boxes.empty()) continue;
    for (int i = 0; i < observed.model.size(); ++i) {
      const model::Coordinate& coordinate = observed.model.coordinates[i];
      const ForceBoxes along = forces_along(boxes, observed, length, i);
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
