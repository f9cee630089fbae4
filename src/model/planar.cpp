#include "jaculus/model/planar.h"

#include <algorithm>
#include <cassert>

namespace jaculus::model {
namespace {

/// Position of the first element for which `match` holds, -1 where there is none.
template <typename List, typename Match>
int find_index(const List& list, Match match) {
  const auto found = std::find_if(list.begin(), list.end(), match);
  return found == list.end() ? -1 : static_cast<int>(found - list.begin());
}

/// Columns of `matrix` but one.
Matrix without_column(const Matrix& matrix, Eigen::Index column) {
  Matrix rest(matrix.rows(), matrix.cols() - 1);
  rest.leftCols(column) = matrix.leftCols(column);
  rest.rightCols(rest.cols() - column) = matrix.rightCols(rest.cols() - column);
  return rest;
}

}  // namespace

int PlanarModel::coordinate_index(const std::string& name) const {
  return find_index(coordinates, [&](const Coordinate& c) { return c.name == name; });
}

int PlanarModel::body_of_joint(const std::string& joint) const {
  // The base has no joint: its empty name must not answer to an empty question.
  return joint.empty() ? -1
                       : find_index(bodies, [&](const PlanarBody& b) { return b.joint == joint; });
}

int PlanarModel::foot_index(const std::string& name) const {
  return find_index(feet, [&](const PlanarPoint& p) { return p.name == name; });
}

int PlanarModel::motor_index(const std::string& joint) const {
  return find_index(motors, [&](const PlanarMotor& m) { return m.joint == joint; });
}

bool PlanarModel::slides(const PlanarMotor& motor) const {
  return bodies[motor.body].kind == JointKind::prismatic;
}

double PlanarModel::total_mass() const {
  double sum = 0.0;
  for (const PlanarBody& body : bodies) sum += body.mass;
  return sum;
}

PlanarModel lock(const PlanarModel& model, const std::string& coordinate, double value) {
  const int index = model.coordinate_index(coordinate);
  assert(index >= 0 && "lock: no such coordinate");
  PlanarModel locked = model;
  const int free_base =
      static_cast<int>(std::count(model.base_free.begin(), model.base_free.end(), true));
  if (index < free_base) {
    int seen = -1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!model.base_free[axis] || ++seen != index) continue;
      locked.base_free[axis] = false;
      locked.base_pose[axis] = value;
    }
  }
  locked.joint_offset += value * model.joint_map.col(index);
  locked.joint_map = without_column(model.joint_map, index);
  locked.coordinates.erase(locked.coordinates.begin() + index);

  // A joint that moved with this coordinate alone stands still now: its motor can't work, its range
  // is settled.
  const auto stands = [&](int body) {
    return !model.joint_map.row(body).isZero(0.0) && locked.joint_map.row(body).isZero(0.0);
  };
  for (int b = 1; b < count_of(locked.bodies); ++b) {
    if (!stands(b)) continue;
    for (const FileJoint& joint : locked.bodies[b].file_joints)
      locked.held.push_back({joint.name, joint.sign * locked.joint_offset[b],
                             locked.bodies[b].kind == JointKind::prismatic});
  }
  std::erase_if(locked.motors, [&](const PlanarMotor& motor) { return stands(motor.body); });
  std::erase_if(locked.joint_ranges, [&](const JointRange& range) { return stands(range.body); });
  return locked;
}

}  // namespace jaculus::model
