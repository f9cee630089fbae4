#include "jaculus/transcription/robot_size.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "jaculus/dynamics/loop_closure.h"

namespace jaculus::transcription {
namespace {

using model::PlanarModel;

InputError of_robot(const model::Robot& robot, const std::string& what) {
  return InputError(fmt::format("robot '{}': {}", robot.name, what));
}

double leg_length(const PlanarModel& model, const model::PlanarPoint& foot) {
  double length = foot.position.norm();
  for (int b = foot.body; b > 0 && model.bodies[b].parent > 0; b = model.bodies[b].parent)
    length += model.bodies[b].origin.norm();
  return length;
}

/// The base at its origin, level; coordinates as named, others at zero or what is nearest.
Vector configuration(const PlanarModel& model, const std::map<std::string, double>& named) {
  Vector q(model.size());
  for (int i = 0; i < model.size(); ++i) {
    const model::Coordinate& c = model.coordinates[i];
    const auto found = named.find(c.name);
    q[i] = found != named.end() ? found->second : std::clamp(0.0, c.range.lower, c.range.upper);
  }
  return q;
}

/// Feet and their derivatives by the coordinates of the legs, at q; false where a loop is open.
struct Feet {
  explicit Feet(const PlanarModel& model) : tree(model), motion(tree) {}

  bool at(const Vector& q) { return dynamics::set_configuration(tree, q, motion); }
  Vec2 place(int foot) { return position(tree.feet[foot], motion.pose); }
  Matrix jacobian(const std::vector<int>& columns) {
    Matrix J = Matrix::Zero(2 * count_of(tree.feet), tree.n);
    for (int f = 0; f < count_of(tree.feet); ++f) {
      dynamics::jacobian_columns(tree.feet[f], motion.pose, motion.columns);
      for (int c = 0; c < motion.columns.count; ++c) {
        J.row(2 * f) += motion.columns.x[c] * motion.G.row(motion.columns.index[c]);
        J.row(2 * f + 1) += motion.columns.z[c] * motion.G.row(motion.columns.index[c]);
      }
    }
    return J(Eigen::all, columns);
  }

  dynamics::AbsoluteTree tree;
  dynamics::Motion motion;
};

/// Where the feet go: below their first joints, none farther than `share` of its leg's length.
Vector places_below(const PlanarModel& model, double share) {
  double height = -kInfinity;
  Vector places(2 * count_of(model.feet));
  for (int f = 0; f < count_of(model.feet); ++f) {
    const Vec2& hip = model.bodies[first_of_leg(model, model.feet[f])].origin;
    places[2 * f] = hip.x();
    height = std::max(height, hip.y() - share * leg_length(model, model.feet[f]));
  }
  for (int f = 0; f < count_of(model.feet); ++f) places[2 * f + 1] = height;
  return places;
}

/// Coordinates that move one foot, or any (-1), when the base stands still.
std::vector<int> legs_of(const PlanarModel& model, Feet& feet, int foot) {
  std::vector<int> all, legs;
  for (int i = 0; i < model.size(); ++i) all.push_back(i);
  Matrix J = feet.jacobian(all);
  if (foot >= 0) J = Matrix(J.middleRows(2 * foot, 2));
  const auto base = std::count(model.base_free.begin(), model.base_free.end(), true);
  for (int i = static_cast<int>(base); i < model.size(); ++i)
    if (!J.col(i).isZero(1e-12)) legs.push_back(i);
  return legs;
}

}  // namespace

int first_of_leg(const PlanarModel& model, const model::PlanarPoint& foot) {
  int body = foot.body;
  while (body > 0 && model.bodies[body].parent > 0) body = model.bodies[body].parent;
  return body;
}

RobotSize robot_size(const model::Robot& robot) {
  const PlanarModel& model = robot.planar;
  if (model.feet.empty() || !(model.gravity > 0.0))
    throw of_robot(robot,
                   "no feet or no gravity, so it has no size as a legged robot; allowed: "
                   "feet in robot.yaml, or plain units");

  RobotSize size;
  for (const model::PlanarPoint& foot : model.feet)
    size.leg_length = std::max(size.leg_length, leg_length(model, foot));
  size.body_weight = model.total_mass() * model.gravity;
  size.leg_time = std::sqrt(size.leg_length / model.gravity);
  size.floor_friction = model.friction;

  Feet feet(model);
  if (!feet.at(configuration(model, rest_coordinates(robot))))
    throw of_robot(robot, "its loops don't close in rest_pose; allowed: a pose that it can have");
  for (int f = 0; f < count_of(model.feet); ++f)
    size.standing_height = std::max(size.standing_height, -feet.place(f).y());
  return size;
}

std::vector<OwnUnit> robot_units(const RobotSize& size) {
  return {{"leg_length", size.leg_length, dimension::length},
          {"standing_height", size.standing_height, dimension::length},
          {"body_weight", size.body_weight, dimension::force},
          {"leg_time", size.leg_time, dimension::time},
          {"floor_friction", size.floor_friction, dimension::none}};
}

std::map<std::string, double> rest_coordinates(const model::Robot& robot) {
  const PlanarModel& model = robot.planar;
  if (robot.rest_pose.empty())
    throw of_robot(robot, "no rest_pose; allowed: rest_pose in robot.yaml, a pose to stand in");

  // theta = T q + offset at the joints that are named
  Matrix rows(count_of(robot.rest_pose), model.size());
  Vector values(count_of(robot.rest_pose));
  int i = 0;
  for (const auto& [joint, value] : robot.rest_pose) {
    const int body = model.body_of_joint(joint);
    rows.row(i) = model.joint_map.row(body);
    values[i++] = value - model.joint_offset[body];
  }

  const Eigen::CompleteOrthogonalDecomposition<Matrix> solver(rows);
  const Vector q = solver.solve(values);
  const Matrix projector = solver.pseudoInverse() * rows;
  std::map<std::string, double> pose;
  constexpr double kRounding = 1e-9;
  for (int c = 0; c < model.size(); ++c) {
    if (std::abs(projector(c, c) - 1.0) >= kRounding) continue;  // not determined by the joints
    const Bounds& range = model.coordinates[c].range;
    const double within = std::clamp(q[c], range.lower, range.upper);  // a pose at its range's end
    pose[model.coordinates[c].name] = std::abs(q[c] - within) < kRounding ? within : q[c];
  }
  return pose;
}

std::vector<std::string> leg_coordinates(const model::Robot& robot, const std::string& foot) {
  const PlanarModel& model = robot.planar;
  const int index = model.foot_index(foot);
  if (index < 0) throw of_robot(robot, fmt::format("no foot '{}'; allowed: its feet", foot));
  Feet feet(model);
  std::vector<std::string> names;
  if (!feet.at(configuration(model, rest_coordinates(robot)))) return names;
  for (const int i : legs_of(model, feet, index)) names.push_back(model.coordinates[i].name);
  return names;
}

std::map<std::string, double> stretched_coordinates(const model::Robot& robot) {
  constexpr double kStretched = 0.92;  // of a leg's length, as robot import has it
  constexpr double kDamping = 1e-4;    // of the normal equations, in leg lengths squared
  constexpr int kSteps = 200;

  const PlanarModel& model = robot.planar;
  const double L = robot_size(robot).leg_length;
  std::map<std::string, double> pose = rest_coordinates(robot);
  Vector q = configuration(model, pose);
  Feet feet(model);
  if (!feet.at(q)) return pose;

  const Vector wanted = places_below(model, kStretched);
  const std::vector<int> legs = legs_of(model, feet, -1);
  for (int step = 0; step < kSteps; ++step) {
    Vector off = wanted;
    for (int f = 0; f < count_of(model.feet); ++f) off.segment<2>(2 * f) -= feet.place(f);
    const Matrix J = feet.jacobian(legs);
    Matrix normal = J.transpose() * J;
    normal.diagonal().array() += kDamping * L * L;
    const Vector change = normal.ldlt().solve(J.transpose() * off);

    Vector next = q;
    for (int i = 0; i < count_of(legs); ++i) {
      const Bounds& range = model.coordinates[legs[i]].range;
      next[legs[i]] = std::clamp(q[legs[i]] + change[i], range.lower, range.upper);
    }
    if (!feet.at(next)) break;
    q = next;
  }

  for (const int i : legs) pose[model.coordinates[i].name] = q[i];
  return pose;
}

}  // namespace jaculus::transcription
