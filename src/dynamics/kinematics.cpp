#include "jaculus/dynamics/kinematics.h"

#include <cassert>
#include <cmath>

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

struct Direction {
  double ex, ez;  // R(phi) r
  double px, pz;  // dR/dphi r
};

Direction rotate(const Segment& s, const Pose& pose) {
  const double c = pose.cosine[s.angle], n = pose.sine[s.angle];
  const double ex = c * s.vector.x() + n * s.vector.y();
  const double ez = -n * s.vector.x() + c * s.vector.y();
  return {ex, ez, ez, -ex};
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
}

Vec2 PointColumns::times(const Vector& v) const {
  double sx = 0.0, sz = 0.0;
  for (int k = 0; k < count; ++k) {
    sx += x[k] * v[index[k]];
    sz += z[k] * v[index[k]];
  }
  return {sx, sz};
}

void PointColumns::add_transposed(const Vec2& w, double scale, Vector& out) const {
  for (int k = 0; k < count; ++k) out[index[k]] += scale * (x[k] * w.x() + z[k] * w.y());
}

void Pose::set(const AbsoluteTree& tree) {
  // Angles and displacements share one vector; a displacement's sine is never read.
  for (int i = 2; i < tree.N; ++i) {
    cosine[i] = std::cos(Y[i]);
    sine[i] = std::sin(Y[i]);
  }
}

void Pose::set_moved(const ConstVectorRef& moved) {
  for (Eigen::Index i = 2; i < moved.size(); ++i) {
    if (moved[i] == 0.0) continue;
    cosine[i] = std::cos(Y[i]);
    sine[i] = std::sin(Y[i]);
  }
}

Vec2 position(const Path& path, const Pose& pose) {
  double px = pose.Y[0], pz = pose.Y[1];
  for (const Segment& s : path) {
    const Direction d = rotate(s, pose);
    const double l = s.slider < 0 ? 1.0 : pose.Y[s.slider];
    px += l * d.ex;
    pz += l * d.ez;
  }
  return {px, pz};
}

void jacobian_columns(const Path& path, const Pose& pose, PointColumns& J) {
  J.clear();
  J.add(0, 1.0, 0.0);
  J.add(1, 0.0, 1.0);
  for (const Segment& s : path) {
    const Direction d = rotate(s, pose);
    if (s.slider < 0) {
      J.add(s.angle, d.px, d.pz);
    } else {
      const double l = pose.Y[s.slider];
      J.add(s.angle, l * d.px, l * d.pz);
      J.add(s.slider, d.ex, d.ez);
    }
  }
}

void add_D(const Path& path, const Pose& pose, const Vector& X, double scale, PointColumns& out) {
  int k = 2;
  for (const Segment& s : path) {
    const Direction d = rotate(s, pose);
    const double rate = scale * X[s.angle];
    if (s.slider < 0) {
      out.x[k] -= rate * d.ex;
      out.z[k] -= rate * d.ez;
      ++k;
    } else {
      const double l = pose.Y[s.slider], slide = scale * X[s.slider];
      out.x[k] += -l * rate * d.ex + slide * d.px;
      out.z[k] += -l * rate * d.ez + slide * d.pz;
      out.x[k + 1] += rate * d.px;
      out.z[k + 1] += rate * d.pz;
      k += 2;
    }
  }
}

void add_E(const Path& path, const Pose& pose, const Vector& V, double scale, PointColumns& out) {
  int k = 2;
  for (const Segment& s : path) {
    const Direction d = rotate(s, pose);
    const double rate = V[s.angle], square = scale * rate * rate;
    if (s.slider < 0) {
      out.x[k] -= square * d.px;
      out.z[k] -= square * d.pz;
      ++k;
    } else {
      const double l = pose.Y[s.slider], cross = 2.0 * scale * rate * V[s.slider];
      out.x[k] += -l * square * d.px - cross * d.ex;
      out.z[k] += -l * square * d.pz - cross * d.ez;
      out.x[k + 1] -= square * d.ex;
      out.z[k + 1] -= square * d.ez;
      k += 2;
    }
  }
}

Vec2 quadratic(const Path& path, const Pose& pose, const Vector& V) {
  double sx = 0.0, sz = 0.0;
  for (const Segment& s : path) {
    const Direction d = rotate(s, pose);
    const double rate = V[s.angle];
    const double l = s.slider < 0 ? 1.0 : pose.Y[s.slider];
    const double cross = s.slider < 0 ? 0.0 : 2.0 * rate * V[s.slider];
    sx += -l * rate * rate * d.ex + cross * d.px;
    sz += -l * rate * rate * d.ez + cross * d.pz;
  }
  return {sx, sz};
}

namespace {

void add_block(const Segment& s, double angle_angle, double angle_slider, Matrix& out) {
  out(s.angle, s.angle) += angle_angle;
  if (s.slider >= 0) {
    out(s.angle, s.slider) += angle_slider;
    out(s.slider, s.angle) += angle_slider;
  }
}

}  // namespace

void add_H(const Path& path, const Pose& pose, const Vec2& w, Matrix& out) {
  for (const Segment& s : path) {
    const Direction d = rotate(s, pose);
    const double we = w.x() * d.ex + w.y() * d.ez, wp = w.x() * d.px + w.y() * d.pz;
    const double l = s.slider < 0 ? 1.0 : pose.Y[s.slider];
    add_block(s, -l * we, wp, out);
  }
}

void add_T(const Path& path, const Pose& pose, const Vec2& w, const Vector& X, Matrix& out) {
  for (const Segment& s : path) {
    const Direction d = rotate(s, pose);
    const double we = w.x() * d.ex + w.y() * d.ez, wp = w.x() * d.px + w.y() * d.pz;
    const double rate = X[s.angle];
    if (s.slider < 0) {
      add_block(s, -rate * wp, 0.0, out);
    } else {
      add_block(s, -pose.Y[s.slider] * wp * rate - we * X[s.slider], -we * rate, out);
    }
  }
}

void add_F(const Path& path, const Pose& pose, const Vec2& w, const Vector& V, Matrix& out) {
  for (const Segment& s : path) {
    const Direction d = rotate(s, pose);
    const double we = w.x() * d.ex + w.y() * d.ez, wp = w.x() * d.px + w.y() * d.pz;
    const double rate = V[s.angle], square = rate * rate;
    if (s.slider < 0) {
      add_block(s, square * we, 0.0, out);
    } else {
      add_block(s, pose.Y[s.slider] * we * square - 2.0 * wp * rate * V[s.slider], -wp * square,
                out);
    }
  }
}

}  // namespace jaculus::dynamics
