#include "diagnosis/forward/start_directions.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "jaculus/dynamics/loop_closure.h"

namespace jaculus::diagnosis {
namespace {

using dynamics::AbsoluteTree;
using dynamics::Motion;
using model::Coordinate;
using model::PlanarModel;
using simulation::StartState;

constexpr double kStep = 1e-5;  // of differences of foot heights

/// Heights of all feet at q; empty where a loop can't close.
Vector foot_heights(const AbsoluteTree& tree, const Vector& q) {
  Motion motion(tree);
  if (!set_configuration(tree, q, motion)) return {};
  Vector heights(count_of(tree.feet));
  for (std::size_t f = 0; f < tree.feet.size(); ++f)
    heights[f] = position(tree.feet[f], motion.pose).y();
  return heights;
}

/// d(foot heights)/dq, feet x n.
Matrix height_jacobian(const AbsoluteTree& tree, const Vector& q) {
  const Vector heights = foot_heights(tree, q);
  Matrix jacobian(heights.size(), q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    Vector moved = q;
    moved[i] += kStep;
    const Vector there = foot_heights(tree, moved);
    jacobian.col(i) = there.size() == heights.size() ? Vector((there - heights) / kStep)
                                                     : Vector::Zero(heights.size());
  }
  return jacobian;
}

/// `scale`: prior deviation of an angle or its rate; what slides is the arc of that at `lever`.
StartDirection direction(const PlanarModel& model, int i, bool rate, double scale, double lever) {
  const Coordinate& coordinate = model.coordinates[i];
  StartDirection d{channel_name(coordinate.name, rate ? trajectory::Quantity::velocity
                                                      : trajectory::Quantity::position),
                   coordinate.angular ? "rad" : "m",
                   coordinate.angular ? scale : lever * scale,
                   Vector::Zero(model.size()),
                   Vector::Zero(model.size()),
                   false};
  if (rate) d.unit += "/s";
  (rate ? d.v : d.q)[i] = 1.0;
  return d;
}

std::vector<StartDirection> free_directions(const PlanarModel& model, const Settings& settings) {
  std::vector<StartDirection> directions;
  for (int i = 0; i < model.size(); ++i) {
    directions.push_back(direction(model, i, false, settings.start_angle, settings.lever));
    directions.push_back(direction(model, i, true, settings.window_start_rate, settings.lever));
  }
  return directions;
}

}  // namespace

std::vector<StartDirection> start_directions(const ObservedDataset& observed,
                                             const StartState& start, const Settings& settings) {
  const PlanarModel& model = observed.model;
  if (observed.measured_input) return free_directions(model, settings);

  const int z = model.coordinate_index("z"), pitch = model.coordinate_index("pitch"),
            x = model.coordinate_index("x");
  const AbsoluteTree tree(model);
  const Vector heights = foot_heights(tree, start.q);
  const bool stands = z >= 0 && pitch >= 0 && heights.size() >= 2 &&
                      heights.cwiseAbs().maxCoeff() < settings.on_floor;
  std::vector<StartDirection> directions;
  const Matrix jacobian = stands ? height_jacobian(tree, start.q) : Matrix();
  for (int i = 0; i < model.size(); ++i) {
    if (i == x || i == z || (stands && i == pitch)) continue;
    StartDirection d = direction(model, i, false, settings.start_angle, settings.lever);
    if (stands) {
      Matrix follow(heights.size(), 2);
      follow << jacobian.col(z), jacobian.col(pitch);
      const Vector step = follow.colPivHouseholderQr().solve(Vector(-jacobian.col(i)));
      d.q[z] = step[0];
      d.q[pitch] = step[1];
      d.stands = true;
    }
    directions.push_back(d);
  }

  if (!stands && pitch >= 0)
    directions.push_back(direction(model, pitch, true, settings.start_pitch_rate, settings.lever));
  return directions;
}

bool moves_start(const simulation::Plant& plant) {
  const auto misreads_joint = [&](const model::PlanarMotor& motor) {
    return plant.sensing.offset.contains(motor.joint) || plant.sensing.scale.contains(motor.joint);
  };
  const std::vector<model::PlanarMotor>& motors = plant.model.motors;
  return plant.ground.foot_radius != 0.0 || plant.ground.compliance != 0.0 ||
         std::any_of(motors.begin(), motors.end(), misreads_joint);
}

}  // namespace jaculus::diagnosis
