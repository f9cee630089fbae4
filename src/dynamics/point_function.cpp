// Functions of a point with first and second derivatives; the formulae are in rigid_body.h.

#include <cassert>

#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::dynamics {

namespace {

/// Columns of D(X) of `path` in the pattern of J.
void rate_columns(const Path& path, const Pose& pose, const Vector& X, const PointColumns& J,
                  PointColumns& D) {
  D.clear();
  for (int k = 0; k < J.count; ++k) D.add(J.index[k], 0.0, 0.0);
  add_D(path, pose, X, 1.0, D);
}

/// g_Y and g_V: derivatives of phi by absolute coordinates and rates.
void absolute_gradients(const Motion& m, const PointSum& point, const Vec2& w_p, const Vec2& w_v,
                        PointScratch& s) {
  s.g_Y.setZero();
  s.g_V.setZero();
  for (const WeightedPath& part : point) {
    jacobian_columns(part.path, m.pose, s.J);
    rate_columns(part.path, m.pose, m.V, s.J, s.D);
    s.J.add_transposed(w_p, part.weight, s.g_Y);
    s.D.add_transposed(w_v, part.weight, s.g_Y);
    s.J.add_transposed(w_v, part.weight, s.g_V);
  }
}

/// Adds the loops' share of L_YY and L_YV; g_Y and g_V must hold phi's gradients.
void add_loop_curvature(const AbsoluteTree& tree, const Motion& m, PointScratch& s) {
  s.dependent = tree.P_d.transpose().lazyProduct(s.g_V);
  s.chi_1 = -m.C_d_inverse.transpose().lazyProduct(s.dependent);
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2 chi = s.chi_1.segment<2>(2 * l);
    for (int side = 0; side < 2; ++side) {
      const Path& path = side == 0 ? tree.loops[l].a : tree.loops[l].b;
      const Vec2 w = side == 0 ? chi : Vec2(-chi);
      jacobian_columns(path, m.pose, s.J);
      rate_columns(path, m.pose, m.V, s.J, s.D);
      s.D.add_transposed(w, 1.0, s.g_Y);
      add_T(path, m.pose, w, m.V, s.YY);
      add_H(path, m.pose, w, s.YV);
    }
  }

  s.dependent = tree.P_d.transpose().lazyProduct(s.g_Y);
  s.chi_0 = -m.C_d_inverse.transpose().lazyProduct(s.dependent);
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2 chi = s.chi_0.segment<2>(2 * l);
    add_H(tree.loops[l].a, m.pose, chi, s.YY);
    add_H(tree.loops[l].b, m.pose, -chi, s.YY);
  }
}

}  // namespace

PointScratch::PointScratch(const AbsoluteTree& tree)
    : g_Y(Vector::Zero(tree.N)),
      g_V(Vector::Zero(tree.N)),
      chi_0(Vector::Zero(tree.nd)),
      chi_1(Vector::Zero(tree.nd)),
      dependent(Vector::Zero(tree.nd)),
      YY(Matrix::Zero(tree.N, tree.N)),
      YV(Matrix::Zero(tree.N, tree.N)),
      YY_G(Matrix::Zero(tree.N, tree.n)),
      YV_G(Matrix::Zero(tree.N, tree.n)),
      YV_X(Matrix::Zero(tree.N, tree.n)) {}

PointSum foot_point(const AbsoluteTree& tree, int foot) {
  assert(foot >= 0 && foot < count_of(tree.feet));
  return {{1.0, tree.feet[foot]}};
}

PointSum centre_of_mass_point(const AbsoluteTree& tree) {
  PointSum sum;
  for (std::size_t b = 0; b < tree.com.size(); ++b) {
    if (tree.mass[b] > 0.0) sum.push_back({tree.mass[b] / tree.total_mass, tree.com[b]});
  }
  return sum;
}

Vec2 point_position(const PointSum& point, const Motion& motion) {
  Vec2 sum = Vec2::Zero();
  for (const WeightedPath& part : point) sum += part.weight * position(part.path, motion.pose);
  return sum;
}

Vec2 point_velocity(const PointSum& point, const Motion& motion) {
  PointColumns J;
  Vec2 sum = Vec2::Zero();
  for (const WeightedPath& part : point) {
    jacobian_columns(part.path, motion.pose, J);
    sum += part.weight * J.times(motion.V);
  }
  return sum;
}

void add_point_gradient(const AbsoluteTree& tree, const Motion& motion, const PointSum& point,
                        const Vec2& w_position, const Vec2& w_velocity, VectorRef gradient,
                        PointScratch& scratch) {
  const int n = tree.n;
  assert(gradient.size() == 2 * n);
  absolute_gradients(motion, point, w_position, w_velocity, scratch);
  gradient.head(n) += motion.G.transpose().lazyProduct(scratch.g_Y);
  gradient.head(n) += motion.X.transpose().lazyProduct(scratch.g_V);
  gradient.tail(n) += motion.G.transpose().lazyProduct(scratch.g_V);
}

void add_point_hessian(const AbsoluteTree& tree, const Motion& motion, const PointSum& point,
                       const Vec2& w_position, const Vec2& w_velocity, MatrixRef hessian,
                       PointScratch& scratch) {
  const int n = tree.n;
  assert(hessian.rows() == 2 * n && hessian.cols() == 2 * n);
  PointScratch& s = scratch;
  s.YY.setZero();
  s.YV.setZero();

  for (const WeightedPath& part : point) {
    add_H(part.path, motion.pose, part.weight * w_position, s.YY);
    add_T(part.path, motion.pose, part.weight * w_velocity, motion.V, s.YY);
    add_H(part.path, motion.pose, part.weight * w_velocity, s.YV);
  }

  if (tree.nd > 0) {
    absolute_gradients(motion, point, w_position, w_velocity, s);
    add_loop_curvature(tree, motion, s);
  }

  // L_YY G + L_YV X, and L_YV G: L_YV is symmetric.
  s.YY_G = s.YY.lazyProduct(motion.G);
  s.YV_X = s.YV.lazyProduct(motion.X);
  s.YV_G = s.YV.lazyProduct(motion.G);
  s.YY_G += s.YV_X;

  hessian.topLeftCorner(n, n) += motion.G.transpose().lazyProduct(s.YY_G);
  hessian.topLeftCorner(n, n) += motion.X.transpose().lazyProduct(s.YV_G);
  hessian.topRightCorner(n, n) += motion.G.transpose().lazyProduct(s.YV_G);
  hessian.bottomLeftCorner(n, n) += motion.G.transpose().lazyProduct(s.YV_G);
}

}  // namespace jaculus::dynamics
