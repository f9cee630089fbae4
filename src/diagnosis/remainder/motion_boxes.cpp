#include "diagnosis/remainder/motion_boxes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/forward/missing_forces.h"
#include "diagnosis/remainder/box_states.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kAdjoining = 1e-6;  // [s]
constexpr int kSteps = 12;
constexpr double kForceReached = 1e-3;  ///< share of the force by which the last step moves it

/// How many equal joints a coordinate moves: a push counts for each.
int joints_of(const model::PlanarModel& robot, const std::string& coordinate) {
  const int motor = robot.motor_index(coordinate), body = robot.body_of_joint(coordinate);
  if (motor >= 0) return robot.motors[motor].count;
  return body >= 0 ? robot.bodies[body].count : 1;
}

/// A window under constant forces along the coordinates; not done where it can't be simulated.
simulation::Simulation run_under(const SimulationSetup& setup, const Vector& force) {
  simulation::Plant plant = setup.plant;
  for (int i = 0; i < force.size(); ++i) {
    const std::string& name = plant.model.coordinates[i].name;
    if (force[i] != 0.0)
      plant.pushes.push_back(
          box_push(name, force[i] / joints_of(plant.model, name), 0.0, setup.options.duration));
  }
  return simulate(plant, setup.controller, setup.start, setup.options);
}

bool is_whole(const simulation::Simulation& run, const SimulationSetup& setup) {
  return run.status == simulation::SimulationStatus::done && run.v.allFinite() &&
         run.time.size() == setup.options.sample_times.size();
}

/// Whether a force can act along every coordinate.
bool pushable(const model::PlanarModel& robot) {
  return std::all_of(robot.coordinates.begin(), robot.coordinates.end(),
                     [&](const model::Coordinate& c) { return has_place(robot, c.name); });
}

/// The constant force along every coordinate under which a window ends with the rates measured, by
/// f <- f + M (v measured - v simulated)/h, from where least was left, and the window under it.
/// The force is empty where nothing can be simulated.
struct Reached {
  Vector force;
  simulation::Simulation run;
  Vector free_rates;  ///< at the end without any force
};

Reached force_reaching(const SimulationSetup& setup, const Matrix& mass, const Vector& rates) {
  const int steps = pushable(setup.plant.model) ? kSteps : 1;
  Reached best;
  Vector force = Vector::Zero(rates.size());
  double least = kInfinity;

  for (int step = 0; step < steps; ++step) {
    simulation::Simulation run = run_under(setup, force);
    if (!is_whole(run, setup)) break;
    const Vector end = run.v.rightCols<1>();
    if (step == 0) best.free_rates = end;
    const Vector more = mass * (rates - end) / setup.options.duration;
    force += more;
    if (more.norm() >= least) continue;
    least = more.norm();
    best.force = force;
    best.run = std::move(run);
    if (least <= kForceReached * force.norm()) break;
  }
  return best;
}

/// Mean of the sign of a rate that goes evenly from one value to another.
double mean_sign(double from, double to) {
  if (from == to) return from > 0.0 ? 1.0 : from < 0.0 ? -1.0 : 0.0;
  return (std::abs(to) - std::abs(from)) / (to - from);
}

/// None where the second window doesn't follow the first, or it can't be simulated.
std::optional<MotionBox> box_between(const PlantForward& forward, int dataset, int segment,
                                     const ObservedDataset& observed,
                                     const std::vector<BoxState>& states, double length,
                                     const Vector& p) {
  if (segment + 1 >= count_of(observed.segments)) return std::nullopt;
  const Segment &own = observed.segments[segment], &next = observed.segments[segment + 1];
  const double apart = next.start - own.start;
  if (next.trial != own.trial || std::abs(apart - length) > kAdjoining) return std::nullopt;
  const BoxState &from = states[segment], &to = states[segment + 1];
  if (from.q.size() == 0 || to.q.size() == 0) return std::nullopt;

  SimulationSetup setup = forward.setup(dataset, segment, p);
  setup.start = {from.q, from.v};
  setup.options.sample_times = Vector::LinSpaced(kPathSamples + 1, 0.0, apart);
  setup.options.duration = apart;
  const dynamics::AbsoluteTree tree(setup.plant.model);
  dynamics::Motion motion(tree);
  if (!set_configuration(tree, to.q, motion)) return std::nullopt;
  Reached reached = force_reaching(setup, mass_matrix(tree, motion), to.v);
  if (reached.force.size() == 0) return std::nullopt;

  MotionBox box;
  box.segment = segment;
  box.trial = own.trial;
  box.start = own.start;
  box.length = apart;
  box.force = std::move(reached.force);
  box.mean_rate = 0.5 * (from.v + to.v);
  box.mean_sign = from.v.binaryExpr(to.v, &mean_sign);
  box.acceleration = (to.v - from.v) / apart;
  box.model_acceleration = (reached.free_rates - from.v) / apart;
  const Eigen::Index bodies = count_of(setup.plant.model.bodies);
  box.angles.resize(2 * bodies);
  box.angles << motion.pose.sine.segment(tree.angle_index(0), bodies),
      motion.pose.cosine.segment(tree.angle_index(0), bodies);
  box.q = std::move(reached.run.q);
  box.v = std::move(reached.run.v);
  box.torque = std::move(reached.run.torque);
  return box;
}

std::vector<MotionBox> boxes_of(const Problem& all, const PlantForward& forward, int dataset,
                                const Vector& p) {
  const ObservedDataset& observed = all.observations.datasets[dataset];
  const double length = all.settings.window_length;
  const std::vector<BoxState> states =
      box_states(observed, all.settings.window_start_half_width, all.settings);
  std::vector<std::optional<MotionBox>> each(observed.segments.size());
  tbb::parallel_for(0, count_of(each), [&](int s) {
    each[s] = box_between(forward, dataset, s, observed, states, length, p);
  });

  std::vector<MotionBox> boxes;
  for (std::optional<MotionBox>& box : each)
    if (box) boxes.push_back(std::move(*box));
  return boxes;
}

}  // namespace

std::vector<std::vector<MotionBox>> motion_boxes(const Problem& all, const PlantForward& forward,
                                                 const Vector& p) {
  std::vector<std::vector<MotionBox>> boxes;
  for (int d = 0; d < count_of(all.observations.datasets); ++d)
    boxes.push_back(all.observations.datasets[d].measured_input ? boxes_of(all, forward, d, p)
                                                                : std::vector<MotionBox>());
  return boxes;
}

}  // namespace jaculus::diagnosis
