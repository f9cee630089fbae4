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

/// Sets one dependent joint of one lane so that its body's `arm` points at the pin.
template <class S>
void point_body_at(const AbsoluteTree& tree, int body, int k, const Vec2& arm,
                   const Vec2& direction, int at, MotionOf<S>& m) {
  const int i = AbsoluteTree::angle_index(body);
  const double sign = tree.P_d(i, k);
  const double d = wrap(sign * (angle_of(direction) - angle_of(arm) - lane(m.pose.Y[i], at)));
  set_lane(m.d[k], at, d);
  for (const int row : tree.P_d_pattern.rows[k])
    set_lane(m.pose.Y[row], at, lane(m.pose.Y[row], at) + tree.P_d(row, k) * d);
}

template <class S>
Vec2 of_lane(const Vec2Of<S>& v, int at) {
  return {lane(v.x(), at), lane(v.y(), at)};
}

template <class S>
bool close_loops(const AbsoluteTree& tree, MotionOf<S>& m) {
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const LoopPaths& loop = tree.loops[l];
    const Vec2Of<S> a = position(loop.anchor_a, m.pose), b = position(loop.anchor_b, m.pose);
    const int k = 2 * l;

    for (int at = 0; at < lanes_of<S>; ++at) {
      const Vec2 from_a = of_lane(a, at), from_b = of_lane(b, at);
      Vec2 pin;
      if (!intersect_circles(from_a, loop.arm_a.norm(), from_b, loop.arm_b.norm(), loop.branch,
                             pin))
        return false;
      point_body_at(tree, loop.body_a, k, loop.arm_a, pin - from_a, at, m);
      point_body_at(tree, loop.body_b, k + 1, loop.arm_b, pin - from_b, at, m);
    }
    for (int side = 0; side < 2; ++side)
      for (const int row : tree.P_d_pattern.rows[k + side]) m.pose.set_angle(row);
  }
  return true;
}

/// Adds sign * columns into two rows of a loop matrix.
template <class S>
void add_rows(const PointColumnsOf<S>& c, double sign, int row, MatrixOf<S>& out) {
  for (int k = 0; k < c.count; ++k) {
    out(row, c.index[k]) += S(sign) * c.x[k];
    out(row + 1, c.index[k]) += S(sign) * c.z[k];
  }
}

template <class S>
void zero_vectors(PointColumnsOf<S>& c) {
  for (int k = 0; k < c.count; ++k) c.x[k] = c.z[k] = S(0.0);
}

/// The loops are dyads: C_d is block lower triangular with 2 x 2 blocks, inverted by substitution.
template <class S>
void invert_dyads(const MatrixOf<S>& C_d, MatrixOf<S>& inverse) {
  using Block = Eigen::Matrix<S, 2, 2>;
  inverse.setZero();
  for (int l = 0; l < C_d.rows(); l += 2) {
    const S a = C_d(l, l), b = C_d(l, l + 1), c = C_d(l + 1, l), d = C_d(l + 1, l + 1);
    const S by_det = S(1.0) / (a * d - b * c);
    Block own;
    own << d * by_det, -b * by_det, -c * by_det, a * by_det;
    inverse.template block<2, 2>(l, l) = own;

    for (int k = 0; k < l; k += 2) {
      Block sum = Block::Constant(S(0.0));
      for (int j = k; j < l; j += 2)
        sum += Block(C_d.template block<2, 2>(l, j))
                   .lazyProduct(Block(inverse.template block<2, 2>(j, k)));
      inverse.template block<2, 2>(l, k) = -own.lazyProduct(sum);
    }
  }
}

/// G = P + P_d D.
template <class S>
void set_map(const AbsoluteTree& tree, MotionOf<S>& m) {
  m.scratch_dn.setZero();
  add_times_sparse<S>(m.C, tree.P, tree.P_pattern, 1.0, m.scratch_dn);
  m.D.setZero();
  subtract_product(m.C_d_inverse, m.scratch_dn, m.D);

  for (int j = 0; j < tree.n; ++j)
    for (const int i : tree.G_pattern.rows[j]) m.G(i, j) = S(tree.P(i, j));
  for (int k = 0; k < tree.nd; ++k)
    for (const int i : tree.P_d_pattern.rows[k])
      for (int j = 0; j < tree.n; ++j) m.G(i, j) += m.D(k, j) * S(tree.P_d(i, k));
}

template <class S>
bool finite(const MatrixOf<S>& matrix) {
  for (int i = 0; i < count_of(matrix); ++i)
    if (!all_finite(matrix.data()[i])) return false;
  return true;
}

}  // namespace

template <class S>
MotionOf<S>::MotionOf(const AbsoluteTree& tree) {
  const int N = tree.N, n = tree.n, nd = tree.nd;
  const auto zeros = [](int rows, int columns) {
    return MatrixOf<S>::Constant(rows, columns, 0.0);
  };
  pose = {zeros(N, 1), zeros(N, 1), zeros(N, 1)};
  d = zeros(nd, 1);
  V = gamma = zeros(N, 1);
  C = scratch_dN = zeros(nd, N);
  C_d = C_d_inverse = zeros(nd, nd);
  D = scratch_dn = scratch_dn2 = zeros(nd, n);
  G = X = zeros(N, n);
  for (int j = 0; j < n; ++j)
    for (const int i : tree.P_pattern.rows[j]) G(i, j) = S(tree.P(i, j));
}

template <class S>
JACULUS_WIDE bool set_configuration(const AbsoluteTree& tree, VectorArg<S> q, MotionOf<S>& m) {
  for (int i = 0; i < tree.N; ++i) m.pose.Y[i] = S(tree.Y_0[i]);
  add_sparse_times<S>(tree.P, tree.P_pattern, 1.0, q, m.pose.Y);
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

  m.C_d.setZero();
  add_times_sparse<S>(m.C, tree.P_d, tree.P_d_pattern, 1.0, m.C_d);
  invert_dyads(m.C_d, m.C_d_inverse);
  set_map(tree, m);
  return finite(m.C_d_inverse);
}

template <class S>
JACULUS_WIDE void set_rates(const AbsoluteTree& tree, VectorArg<S> v, MotionOf<S>& m) {
  m.V.setZero();
  add_sparse_times<S>(m.G, tree.G_pattern, 1.0, v, m.V);
  m.gamma.setZero();
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2Of<S> curvature =
        quadratic(tree.loops[l].a, m.pose, m.V) - quadratic(tree.loops[l].b, m.pose, m.V);
    for (int i = 0; i < 2; ++i) {
      const int row = 2 * l + i;
      for (int k = 0; k < tree.nd; ++k) {
        const S turn = m.C_d_inverse(k, row) * curvature[i];
        for (const int b : tree.P_d_pattern.rows[k]) m.gamma[b] -= S(tree.P_d(b, k)) * turn;
      }
    }
  }
}

template <class S>
JACULUS_WIDE void set_rate_sensitivity(const AbsoluteTree& tree, MotionOf<S>& m) {
  if (tree.nd == 0) return;
  m.X.setZero();
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

  m.scratch_dn.setZero();
  add_times_sparse<S>(m.scratch_dN, m.G, tree.G_pattern, 1.0, m.scratch_dn);
  set_product(m.C_d_inverse, m.scratch_dn, m.scratch_dn2);
  add_sparse_times<S>(tree.P_d, tree.P_d_pattern, -1.0, m.scratch_dn2, m.X);
}

template <class S>
JACULUS_WIDE void loop_acceleration_derivatives(const AbsoluteTree& tree, MotionOf<S>& m,
                                                const VectorOf<S>& A, bool at_rest, MatrixOf<S>& dY,
                                                MatrixOf<S>& dV) {
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

#define JACULUS_INSTANTIATE(S)                                                         \
  template struct MotionOf<S>;                                                         \
  template bool set_configuration<S>(const AbsoluteTree&, VectorArg<S>, MotionOf<S>&); \
  template void set_rates<S>(const AbsoluteTree&, VectorArg<S>, MotionOf<S>&);         \
  template void set_rate_sensitivity<S>(const AbsoluteTree&, MotionOf<S>&);            \
  template void loop_acceleration_derivatives<S>(                                      \
      const AbsoluteTree&, MotionOf<S>&, const VectorOf<S>&, bool, MatrixOf<S>&, MatrixOf<S>&);

JACULUS_INSTANTIATE(double)
JACULUS_INSTANTIATE(Lanes)
#undef JACULUS_INSTANTIATE

Vector joint_positions(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& q,
                       const Motion& m) {
  return tree.joint_row_q * q + tree.joint_row_d * m.d + tree.joint_0;
}

Vector joint_velocities(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& v,
                        const Motion& m) {
  return tree.joint_row_q * v + tree.joint_row_d * (m.D * v);
}

}  // namespace jaculus::dynamics
