#include "jaculus/dynamics/loop_closure.h"

#include <cmath>
#include <numbers>

#include "jaculus/core/small_product.h"

namespace jaculus::dynamics {

namespace {

/// The angle of R(phi) (1, 0) = (cos phi, -sin phi).
double angle_of(const Vec2& v) { return std::atan2(-v.y(), v.x()); }

double wrap(double angle) {
  return angle -
         2.0 * std::numbers::pi * std::ceil((angle - std::numbers::pi) / (2.0 * std::numbers::pi));
}

/// The intersection of the circles about a and b on the stated branch; false where they do not
/// meet.
bool intersect_circles(const Vec2& a, double ra, const Vec2& b, double rb, double branch,
                       Vec2& pin) {
  const Vec2 u = b - a;
  const double distance = u.norm();
  const double along = (distance * distance + ra * ra - rb * rb) / (2.0 * distance);
  const double height2 = ra * ra - along * along;
  if (!(height2 > 0.0)) return false;  // also catches coinciding centres (NaN)
  const Vec2 e = u / distance;
  pin = a + along * e + branch * std::sqrt(height2) * Vec2(e.y(), -e.x());
  return true;
}

/// Sets one dependent joint so that its body's `arm` points at the pin, and updates the pose.
void point_body_at(const AbsoluteTree& tree, int body, int k, const Vec2& arm,
                   const Vec2& direction, Motion& m) {
  const int i = AbsoluteTree::angle_index(body);
  const double sign = tree.P_d(i, k);
  m.d[k] = wrap(sign * (angle_of(direction) - angle_of(arm) - m.pose.Y[i]));
  m.pose.Y += tree.P_d.col(k) * m.d[k];
  m.pose.set_moved(tree.P_d.col(k));
}

bool close_loops(const AbsoluteTree& tree, Motion& m) {
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const LoopPaths& loop = tree.loops[l];
    const Vec2 a = position(loop.anchor_a, m.pose), b = position(loop.anchor_b, m.pose);
    Vec2 pin;
    if (!intersect_circles(a, loop.arm_a.norm(), b, loop.arm_b.norm(), loop.branch, pin))
      return false;
    const int k = 2 * l;
    point_body_at(tree, loop.body_a, k, loop.arm_a, pin - a, m);
    point_body_at(tree, loop.body_b, k + 1, loop.arm_b, pin - b, m);
  }
  return true;
}

/// Adds sign * columns into two rows of a loop matrix.
void add_rows(const PointColumns& c, double sign, int row, Matrix& out) {
  for (int k = 0; k < c.count; ++k) {
    out(row, c.index[k]) += sign * c.x[k];
    out(row + 1, c.index[k]) += sign * c.z[k];
  }
}

void zero_vectors(PointColumns& c) {
  for (int k = 0; k < c.count; ++k) c.x[k] = c.z[k] = 0.0;
}

}  // namespace

Motion::Motion(const AbsoluteTree& tree) {
  const int N = tree.N, n = tree.n, nd = tree.nd;
  pose = {Vector::Zero(N), Vector::Zero(N), Vector::Zero(N)};
  d = Vector::Zero(nd);
  V = gamma = Vector::Zero(N);
  C = scratch_dN = Matrix::Zero(nd, N);
  C_d = C_d_inverse = Matrix::Zero(nd, nd);
  D = scratch_dn = scratch_dn2 = Matrix::Zero(nd, n);
  G = X = Matrix::Zero(N, n);
  G = tree.P;
  Gt = G.transpose();
  Xt = Matrix::Zero(n, N);
}

bool set_configuration(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& q, Motion& m) {
  m.pose.Y = tree.Y_0;
  m.pose.Y.noalias() += tree.P.lazyProduct(q);
  m.pose.set(tree);
  if (tree.nd == 0) return true;
  if (!close_loops(tree, m)) return false;

  m.C.setZero();
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const int row = 2 * l;
    jacobian_columns(tree.loops[l].a, m.pose, m.columns);
    add_rows(m.columns, 1.0, row, m.C);
    jacobian_columns(tree.loops[l].b, m.pose, m.columns);
    add_rows(m.columns, -1.0, row, m.C);
  }

  m.C_d = m.C.lazyProduct(tree.P_d);
  // The loops are dyads: C_d is block lower triangular with 2 x 2 blocks, inverted by substitution.
  m.C_d_inverse.setZero();
  for (int l = 0; l < tree.nd; l += 2) {
    const Mat2 inverse = Mat2(m.C_d.block<2, 2>(l, l)).inverse();
    m.C_d_inverse.block<2, 2>(l, l) = inverse;
    for (int k = 0; k < l; k += 2) {
      Mat2 sum = Mat2::Zero();
      for (int j = k; j < l; j += 2)
        sum += m.C_d.block<2, 2>(l, j) * m.C_d_inverse.block<2, 2>(j, k);
      m.C_d_inverse.block<2, 2>(l, k) = -inverse * sum;
    }
  }

  set_product(m.C, tree.P, m.scratch_dn);
  m.D.setZero();
  subtract_product(m.C_d_inverse, m.scratch_dn, m.D);
  m.G = tree.P;
  add_product(tree.P_d, m.D, m.G);
  m.Gt = m.G.transpose();
  return m.C_d_inverse.allFinite();
}

void set_rates(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& v, Motion& m) {
  m.V = m.G.lazyProduct(v);
  m.gamma.setZero();
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2 curvature =
        quadratic(tree.loops[l].a, m.pose, m.V) - quadratic(tree.loops[l].b, m.pose, m.V);
    for (int i = 0; i < 2; ++i) {
      const int row = 2 * l + i;
      for (int k = 0; k < tree.nd; ++k)
        m.gamma -= tree.P_d.col(k) * (m.C_d_inverse(k, row) * curvature[i]);
    }
  }
}

void set_rate_sensitivity(const AbsoluteTree& tree, Motion& m) {
  m.X.setZero();
  if (tree.nd == 0) return;
  m.scratch_dN.setZero();
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const int row = 2 * l;
    const Path* sides[2] = {&tree.loops[l].a, &tree.loops[l].b};
    for (int side = 0; side < 2; ++side) {
      jacobian_columns(*sides[side], m.pose, m.columns);
      zero_vectors(m.columns);
      add_D(*sides[side], m.pose, m.V, 1.0, m.columns);
      add_rows(m.columns, side == 0 ? 1.0 : -1.0, row, m.scratch_dN);
    }
  }

  set_product(m.scratch_dN, m.G, m.scratch_dn);
  set_product(m.C_d_inverse, m.scratch_dn, m.scratch_dn2);
  subtract_product(tree.P_d, m.scratch_dn2, m.X);
  m.Xt = m.X.transpose();
}

void loop_acceleration_derivatives(const AbsoluteTree& tree, Motion& m, const Vector& A,
                                   bool at_rest, Matrix& dY, Matrix& dV) {
  dY.setZero();
  dV.setZero();
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const int row = 2 * l;
    const Path* sides[2] = {&tree.loops[l].a, &tree.loops[l].b};
    for (int side = 0; side < 2; ++side) {
      const double sign = side == 0 ? 1.0 : -1.0;
      jacobian_columns(*sides[side], m.pose, m.columns);
      if (!at_rest) {
        zero_vectors(m.columns);
        add_D(*sides[side], m.pose, m.V, 2.0, m.columns);
        add_rows(m.columns, sign, row, dV);
      }

      zero_vectors(m.columns);
      add_D(*sides[side], m.pose, A, 1.0, m.columns);
      if (!at_rest) add_E(*sides[side], m.pose, m.V, 1.0, m.columns);
      add_rows(m.columns, sign, row, dY);
    }
  }
}

Vector joint_positions(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& q,
                       const Motion& m) {
  return tree.joint_row_q * q + tree.joint_row_d * m.d + tree.joint_0;
}

Vector joint_velocities(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& v,
                        const Motion& m) {
  return tree.joint_row_q * v + tree.joint_row_d * (m.D * v);
}

}  // namespace jaculus::dynamics
