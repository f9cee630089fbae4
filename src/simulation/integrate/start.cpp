// The states that runs begin in: poses from named values, feet on the floor.

#include "simulation/integrate/start.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "jaculus/core/angle.h"
#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/simulation/simulate.h"
#include "simulation/plant/named_values.h"

namespace jaculus::simulation {

namespace {

/// The key that a pose is stated by; of which file, whoever read that knows.
const InputPlace kInitial{.key = "initial"};

/// Coordinates from named values: of coordinates themselves and of joints that follow from them.
Vector initial_coordinates(const model::PlanarModel& model,
                           const std::map<std::string, double>& values) {
  std::vector<Eigen::RowVectorXd> rows;
  std::vector<double> right;
  std::vector<std::string> known;
  for (const model::Coordinate& c : model.coordinates) known.push_back(c.name);
  for (const model::PlanarBody& body : model.bodies)
    if (!body.joint.empty() && model.coordinate_index(body.joint) < 0) known.push_back(body.joint);
  for (const auto& [name, value] : values) {
    const int i = model.coordinate_index(name), b = model.body_of_joint(name);
    if (i >= 0) {
      rows.emplace_back(Eigen::RowVectorXd::Unit(model.size(), i));
      right.push_back(value);
    } else if (b >= 0) {
      if (std::find(model.dependent.begin(), model.dependent.end(), b) != model.dependent.end())
        continue;
      if (model.joint_map.row(b).isZero(0.0)) continue;  // locked
      rows.emplace_back(model.joint_map.row(b));
      right.push_back(value - model.joint_offset[b]);
    } else {
      throw InputError(
          kInitial, fmt::format("'{}' is no coordinate or joint of the robot{}; allowed: {}", name,
                                yaml::did_you_mean(name, known), fmt::join(known, ", ")));
    }
  }

  // a base that is not mentioned is level at the origin
  for (const char* name : {"x", "z", "pitch"}) {
    const int i = model.coordinate_index(name);
    if (i < 0 || values.count(name) > 0) continue;
    rows.emplace_back(Eigen::RowVectorXd::Unit(model.size(), i));
    right.push_back(0.0);
  }

  Matrix map(rows.size(), model.size());
  Vector b(map.rows());
  for (Eigen::Index r = 0; r < map.rows(); ++r) {
    map.row(r) = rows[r];
    b[r] = right[r];
  }

  const Eigen::ColPivHouseholderQR<Matrix> qr(map);
  if (qr.rank() < model.size()) {
    std::vector<std::string> missing;
    for (const model::Coordinate& c : model.coordinates) {
      const int i = model.coordinate_index(c.name);
      if (map.col(i).isZero(0.0)) missing.push_back(c.name);
    }
    throw InputError(kInitial,
                     fmt::format("the pose leaves {} open; allowed: a value of every coordinate{}",
                                 missing.empty() ? std::string("coordinates")
                                                 : fmt::format("'{}'", fmt::join(missing, "', '")),
                                 missing.empty() ? ""
                                                 : fmt::format(", {{{}: VALUE}}",
                                                               fmt::join(missing, ": VALUE, "))));
  }

  return qr.solve(b);
}

/// Turns and lifts the base until both feet of a standing robot touch: stated poses close to some
/// 0.1 mm only, and a robot that stood on one foot would tip before its first command. One whose
/// feet are meant to differ stays as it is.
void level(const Plant& plant, const dynamics::AbsoluteTree& tree, Vector& q) {
  const model::PlanarModel& model = plant.model;
  const int z = model.coordinate_index("z"), pitch = model.coordinate_index("pitch");
  constexpr double kMeant = 0.01;  // difference of foot heights that is no error [m]
  if (pitch < 0 || model.feet.size() != 2) return;

  const int x = model.coordinate_index("x");
  const double base_x = x >= 0 ? q[x] : model.base_pose[0];
  dynamics::Motion motion(tree);
  const Vector stated = q;
  for (int i = 0; i < 20; ++i) {
    if (!dynamics::set_configuration(tree, q, motion)) break;
    const Vec2 a = dynamics::foot_position(tree, motion, 0),
               b = dynamics::foot_position(tree, motion, 1);
    const double floor = plant.ground.height + plant.ground.foot_radius;
    if (i == 0 && (std::abs(a.y() - b.y()) > kMeant || std::abs(a.x() - b.x()) < kMeant)) break;
    if (std::abs(a.y() - b.y()) < 1e-13 && std::abs(a.y() - floor) < 1e-13) return;
    // Height of a point falls by its distance ahead of the base for a unit of pitch, which is
    // nose-down.
    const double turn = (a.y() - b.y()) / (a.x() - b.x());
    q[pitch] += turn;
    q[z] += floor - a.y() + turn * (a.x() - base_x);
  }

  q = stated;
}

/// The range that a motor's joint can be in [rad or m]: that of its stops. A pose that is stated
/// beyond them is a contradiction of the files, which the simulation reports; so it stays.
Bounds reachable(const Plant& plant, const std::string& joint, double stated) {
  Bounds range;
  for (const JointStop& stop : plant.stops)
    if (stop.joint == joint) range = stop.range;
  return {std::min(range.lower, stated), std::max(range.upper, stated)};
}

/// Rows of the joint map, a motor each.
Matrix motor_rows(const model::PlanarModel& model) {
  Matrix rows(std::ssize(model.motors), model.size());
  for (Eigen::Index m = 0; m < rows.rows(); ++m)
    rows.row(m) = model.joint_map.row(model.motors[m].body);
  return rows;
}

/// Moves coordinates, or their rates, so that the motors' joints change by so much.
void move_motors(const Matrix& rows, const Vector& change, Vector& coordinates) {
  if (!change.isZero(0.0)) coordinates += rows.completeOrthogonalDecomposition().solve(change);
}

double scale_of(const Plant& plant, const model::PlanarMotor& motor) {
  return value_or(plant.sensing.scale, motor.joint, 1.0);
}

/// Joints with motors are brought to where their encoders, as they read, show the pose q; where
/// that is beyond a stop, they rest against it. `stated`: the pose by the files.
void place_by_encoders(const Plant& plant, const Vector& stated, Vector& q) {
  const model::PlanarModel& model = plant.model;
  if (plant.sensing.offset.empty() && plant.sensing.scale.empty() && q == stated) return;
  const Matrix rows = motor_rows(model);
  Vector change = rows * q;
  for (Eigen::Index m = 0; m < change.size(); ++m) {
    const model::PlanarMotor& motor = model.motors[m];
    const double zero = model.joint_offset[motor.body], angle = change[m] + zero;
    const double offset = value_or(plant.sensing.offset, motor.joint, 0.0);
    const Bounds range = reachable(plant, motor.joint, rows.row(m).dot(stated) + zero);
    change[m] =
        std::clamp((angle - offset) / scale_of(plant, motor), range.lower, range.upper) - angle;
  }
  move_motors(rows, change, q);
}

/// The base as it is where motion capture, as it reads, shows the state read: both are about the
/// point that it tracks on axes that may be tilted (experiment/channel_values.h).
void place_by_tracked_point(const Plant& plant, StartState& state) {
  const Vec2& point = plant.sensing.tracked_point;
  const double tilt = plant.sensing.mocap_tilt;
  const int x = plant.model.coordinate_index("x"), z = plant.model.coordinate_index("z"),
            pitch = plant.model.coordinate_index("pitch");
  if (x < 0 || z < 0 || (point.isZero(0.0) && tilt == 0.0)) return;
  const double angle = pitch < 0 ? 0.0 : state.q[pitch];
  const double turning = pitch < 0 ? 0.0 : state.v[pitch];
  const Vec2 arm = turned(angle, point), moved(arm.y(), -arm.x());
  const Vec2 place = turned(tilt, {state.q[x], state.q[z]}) - arm;
  const Vec2 speed = turned(tilt, {state.v[x], state.v[z]}) - turning * moved;
  state.q[x] = place.x();
  state.q[z] = place.y();
  state.v[x] = speed.x();
  state.v[z] = speed.y();
}

}  // namespace

void level_feet(const Plant& plant, Vector& q) {
  level(plant, dynamics::AbsoluteTree(plant.model), q);
}

StartState state_as_read(const Plant& plant, const StartState& read) {
  StartState state = read;
  place_by_encoders(plant, read.q, state.q);
  place_by_tracked_point(plant, state);
  if (plant.sensing.scale.empty()) return state;
  const Matrix rows = motor_rows(plant.model);
  Vector change = rows * read.v;
  for (Eigen::Index m = 0; m < change.size(); ++m)
    change[m] *= 1.0 / scale_of(plant, plant.model.motors[m]) - 1.0;
  move_motors(rows, change, state.v);
  return state;
}

StartState reference_start(const Plant& plant, const Reference& reference, const Vector& off) {
  const model::PlanarModel& model = plant.model;
  const Vector stated = initial_coordinates(model, reference.initial);
  StartState start{stated, Vector::Zero(model.size())};
  if (off.size() > 0) start.q += off;
  place_by_encoders(plant, stated, start.q);
  const int z = model.coordinate_index("z");
  if (z < 0 || model.feet.empty()) return start;
  const dynamics::AbsoluteTree tree(model);
  dynamics::Motion motion(tree);
  if (!dynamics::set_configuration(tree, start.q, motion))
    throw InputError(kInitial, "the loops can't be closed in this pose; allowed: one that closes");
  double lowest = kInfinity;
  for (int f = 0; f < count_of(model.feet); ++f)
    lowest =
        std::min(lowest, dynamics::foot_position(tree, motion, f).y() - plant.ground.foot_radius);
  constexpr double kDrop = 0.05;  // higher above the floor than any plan's own error [m]
  if (lowest - plant.ground.height > kDrop) return start;
  start.q[z] += plant.ground.height - lowest;
  level(plant, tree, start.q);
  if (plant.ground.compliance == 0.0) return start;

  // The floor gives way until it carries the weight, by the feet that touch.
  int touching = 0;
  for (int f = 0; f < count_of(model.feet); ++f) {
    const double height = dynamics::foot_position(tree, motion, f).y() - plant.ground.foot_radius;
    if (height - lowest < 1e-4) touching += model.feet[f].count;
  }

  start.q[z] -= model.total_mass() * model.gravity * plant.ground.compliance / touching;
  return start;
}

}  // namespace jaculus::simulation
