#include <cassert>

#include "jaculus/dynamics/kinematics.h"

namespace jaculus::dynamics {

namespace {

/// Chain of bodies from the one after the base to `body`.
std::vector<int> chain_to(const model::PlanarModel& model, int body) {
  std::vector<int> chain;
  for (int b = body; b > 0; b = model.bodies[b].parent) chain.insert(chain.begin(), b);
  return chain;
}

/// Absolute index of the displacement of a prismatic joint, counted after all angles.
int slider_index(const model::PlanarModel& model, int body) {
  int index = 2 + count_of(model.bodies);
  for (int b = 0; b < body; ++b)
    index += model.bodies[b].kind == model::JointKind::prismatic ? 1 : 0;
  return index;
}

/// Rows of the absolute coordinates that the joint of body b moves; its parent's are there.
void add_joint(const model::PlanarModel& model, int b, AbsoluteTree& tree) {
  const model::PlanarBody& link = model.bodies[b];
  const int i = AbsoluteTree::angle_index(b), parent = AbsoluteTree::angle_index(link.parent);
  tree.P.row(i) = tree.P.row(parent);
  tree.P_d.row(i) = tree.P_d.row(parent);
  tree.Y_0[i] = tree.Y_0[parent] + link.angle_offset;

  const bool revolute = link.kind == model::JointKind::revolute;
  const int target = revolute ? i : slider_index(model, b);
  const double sign = revolute ? link.sign : 1.0;
  tree.P.row(target) += sign * tree.joint_row_q.row(b);
  tree.P_d.row(target) += sign * tree.joint_row_d.row(b);
  tree.Y_0[target] += sign * tree.joint_0[b];
}

/// Rotors and torques of the motors on the generalised coordinates.
void add_motors(const model::PlanarModel& model, AbsoluteTree& tree) {
  const int n = tree.n;
  tree.armature = Matrix::Zero(n, n);
  tree.input_map = Matrix::Zero(n, count_of(model.motors));

  for (int m = 0; m < count_of(model.motors); ++m) {
    const model::PlanarMotor& motor = model.motors[m];
    const Vector row = tree.joint_row_q.row(motor.body).transpose();
    tree.armature +=
        motor.count * motor.gear * motor.gear * motor.rotor_inertia * row * row.transpose();
    tree.input_map.col(m) = motor.count * row;
  }
}

/// Where G and X may differ from zero: a dependent joint moves with what moves its loop, the base's
/// translation not, which moves both its ends alike.
void find_patterns(AbsoluteTree& tree) {
  tree.P_pattern = ColumnPattern::of(tree.P);
  tree.P_d_pattern = ColumnPattern::of(tree.P_d);

  Matrix moves = tree.P.cwiseAbs();                 // N x n, of G as far as it is known
  Matrix dependent = Matrix::Zero(tree.N, tree.n);  // of X
  for (int l = 0; l < count_of(tree.loops); ++l) {
    Vector by = Vector::Zero(tree.n);
    for (const Path* path : {&tree.loops[l].a, &tree.loops[l].b})
      for (const Segment& s : *path)
        for (const int i : {s.angle, std::max(s.slider, s.angle)}) by += moves.row(i).transpose();
    const Matrix added = tree.P_d.middleCols(2 * l, 2).cwiseAbs().rowwise().sum() * by.transpose();
    dependent += added;
    moves += added;
  }
  tree.G_pattern = ColumnPattern::of(moves);
  tree.X_pattern = ColumnPattern::of(dependent);
}

}  // namespace

Path AbsoluteTree::path_to(const model::PlanarModel& model, int body, const Vec2& point) const {
  Path path;
  for (int b : chain_to(model, body)) {
    const model::PlanarBody& link = model.bodies[b];
    if (!link.origin.isZero()) path.push_back({angle_index(link.parent), -1, link.origin});
    if (link.kind == model::JointKind::prismatic)
      path.push_back({angle_index(link.parent), slider_index(model, b), link.axis});
  }
  if (!point.isZero()) path.push_back({angle_index(body), -1, point});
  assert(2 + 2 * path.size() <= kMaxColumns);
  return path;
}

AbsoluteTree::AbsoluteTree(const model::PlanarModel& model) {
  const int bodies = count_of(model.bodies);
  n = model.size();
  N = slider_index(model, bodies);
  nd = count_of(model.dependent);
  P = Matrix::Zero(N, n);
  P_d = Matrix::Zero(N, nd);
  Y_0 = Vector::Zero(N);
  joint_row_q = model.joint_map;
  joint_row_d = Matrix::Zero(bodies, nd);
  joint_0 = model.joint_offset;
  for (int k = 0; k < nd; ++k) joint_row_d(model.dependent[k], k) = 1.0;

  int column = 0;
  for (int i = 0; i < 3; ++i) {
    if (model.base_free[i]) {
      if (i < 2) cyclic.push_back(column);
      P(i, column++) = 1.0;
    } else {
      Y_0[i] = model.base_pose[i];
    }
  }
  for (int b = 1; b < bodies; ++b) add_joint(model, b, *this);

  gravity = model.gravity;
  total_mass = model.total_mass();
  for (int b = 0; b < bodies; ++b) {
    const model::PlanarBody& link = model.bodies[b];
    mass.push_back(link.mass);
    inertia.push_back(link.inertia);
    com.push_back(path_to(model, b, link.com));
    origin.push_back(path_to(model, b, Vec2::Zero()));
  }
  for (const model::PlanarPoint& foot : model.feet)
    feet.push_back(path_to(model, foot.body, foot.position));
  for (const model::PlanarLoop& loop : model.loops) {
    loops.push_back(
        {path_to(model, loop.body_a, loop.point_a), path_to(model, loop.body_b, loop.point_b),
         path_to(model, loop.body_a, Vec2::Zero()), path_to(model, loop.body_b, Vec2::Zero()),
         loop.point_a, loop.point_b, loop.body_a, loop.body_b, loop.branch});
  }

  add_motors(model, *this);
  find_patterns(*this);
}

}  // namespace jaculus::dynamics
