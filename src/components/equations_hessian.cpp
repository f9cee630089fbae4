// Second derivatives of the equations of motion by the adjoint of equations.h.

#include "components/point_terms.h"
#include "jaculus/core/small_product.h"

namespace jaculus::components {

namespace {

/// Second derivatives of nu . (body terms).
template <class S>
JACULUS_WIDE void add_body_hessian(const dynamics::AbsoluteTree& tree, EquationsPointOf<S>& p) {
  const dynamics::PoseOf<S>& pose = p.motion.pose;
  const VectorOf<S>& V = p.motion.V;
  for (std::size_t b = 0; b < tree.com.size(); ++b) {
    const double mass = tree.mass[b];
    if (mass == 0.0) continue;
    const dynamics::Path& path = tree.com[b];

    dynamics::jacobian_columns(path, pose, p.J);
    acceleration_columns(path, p.A, p);
    p.Dnu.take_pattern(p.J);
    dynamics::add_D(path, pose, p.nu, 1.0, p.Dnu);
    const Vec2Of<S> shift = S(mass) * p.J.times(p.nu), twice = S(2.0) * shift;

    add_outer(p.PY, kTranslation, p.Dnu, kTranslation, mass, p.YY);
    add_outer(p.Dnu, kTranslation, p.PY, kTranslation, mass, p.YY);
    dynamics::add_T(path, pose, weight(tree, b, p), p.nu, p.YY);
    dynamics::add_T(path, pose, shift, p.A, p.YY);
    add_outer(p.Dnu, kTranslation, p.J, 0, mass, p.YA);
    dynamics::add_H(path, pose, shift, p.YA);

    if (p.impact) continue;
    dynamics::add_F(path, pose, shift, V, p.YY);
    add_outer(p.Dnu, kTranslation, p.PV, kTranslation, mass, p.YV);
    dynamics::add_T(path, pose, twice, V, p.YV);
    dynamics::add_H(path, pose, twice, p.VV);
  }
}

/// Second derivatives of kappa . (point's acceleration at A) - force . (virtual displacement), and
/// -D(nu) into two columns of `D`. `jump`: kappa . J A alone, where A holds the rates before an
/// impact as well.
template <class S>
JACULUS_WIDE void add_constraint_hessian(const dynamics::Path& path, const Vec2Of<S>& force,
                                         const Vec2Of<S>& kappa, double sign, const VectorOf<S>& A,
                                         bool jump, int row, MatrixOf<S>& D,
                                         EquationsPointOf<S>& p) {
  const dynamics::PoseOf<S>& pose = p.motion.pose;

  const Vec2Of<S> k = S(sign) * kappa, twice = S(2.0) * k, against = S(-sign) * force;
  dynamics::add_T(path, pose, against, p.nu, p.YY);
  dynamics::add_T(path, pose, k, A, p.YY);
  dynamics::add_H(path, pose, k, p.YA);
  if (jump) dynamics::add_H(path, pose, k, p.YV);
  if (!p.impact) {
    dynamics::add_F(path, pose, k, p.motion.V, p.YY);
    dynamics::add_T(path, pose, twice, p.motion.V, p.YV);
    dynamics::add_H(path, pose, twice, p.VV);
  }

  dynamics::jacobian_columns(path, pose, p.J);
  p.Dnu.take_pattern(p.J);
  dynamics::add_D(path, pose, p.nu, -sign, p.Dnu);
  for (int c = kTranslation; c < p.Dnu.count; ++c) {
    D(p.Dnu.index[c], row) += p.Dnu.x[c];
    D(p.Dnu.index[c], row + 1) += p.Dnu.z[c];
  }
}

/// Multipliers that make the sum stationary in the dependent joints' rates and values, and their
/// curvature.
template <class S>
JACULUS_WIDE void add_dependent_curvature(const dynamics::AbsoluteTree& tree,
                                          EquationsPointOf<S>& p) {
  const dynamics::MotionOf<S>& m = p.motion;
  p.chi_0.setZero();
  add_sparse_transposed_times<S>(tree.P_d, tree.P_d_pattern, -1.0, p.g_V, p.chi_0);
  set_product(p.C_d_inverse_t, p.chi_0, p.chi_1);

  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2Of<S> chi = p.chi_1.template segment<2>(2 * l), against = -chi;
    for (int side = 0; side < 2; ++side) {
      const dynamics::Path& path = side == 0 ? tree.loops[l].a : tree.loops[l].b;
      const Vec2Of<S>& w = side == 0 ? chi : against;
      dynamics::jacobian_columns(path, m.pose, p.J);
      p.Dnu.take_pattern(p.J);
      dynamics::add_D(path, m.pose, m.V, 1.0, p.Dnu);
      p.Dnu.add_transposed(w, 1.0, p.g_Y);
      dynamics::add_T(path, m.pose, w, m.V, p.YY);
      dynamics::add_H(path, m.pose, w, p.YV);
    }
  }

  p.kappa_l.setZero();
  add_sparse_transposed_times<S>(tree.P_d, tree.P_d_pattern, -1.0, p.g_Y, p.kappa_l);
  set_product(p.C_d_inverse_t, p.kappa_l, p.chi_0);
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2Of<S> chi = p.chi_0.template segment<2>(2 * l), against = -chi;
    dynamics::add_H(tree.loops[l].a, m.pose, chi, p.YY);
    dynamics::add_H(tree.loops[l].b, m.pose, against, p.YY);
  }
}

/// Feet: their constraints' second derivatives.
template <class S>
void add_feet_hessian(const dynamics::AbsoluteTree& tree, EquationsPointOf<S>& p) {
  p.D_feet.setZero();
  for (int k = 0; k < count_of(p.feet); ++k) {
    const int row = 2 * k;
    const Vec2Of<S> force = p.force.template segment<2>(row),
                    kappa = p.adjoint.template segment<2>(tree.n + row);
    add_constraint_hessian(tree.feet[p.feet[k]], force, kappa, 1.0, p.A_feet, p.impact, row,
                           p.D_feet, p);
  }
}

/// Loops: their constraints' second derivatives, with multipliers from the balance of the adjoint.
template <class S>
void add_loops_hessian(const dynamics::AbsoluteTree& tree, EquationsPointOf<S>& p) {
  const int m = count_of(p.force);
  p.g_V.setZero();
  add_product(p.M, p.nu, p.g_V);
  if (m > 0) add_transposed_product(p.J_f, p.adjoint.tail(m), p.g_V);
  p.chi_0.setZero();
  add_sparse_transposed_times<S>(tree.P_d, tree.P_d_pattern, -1.0, p.g_V, p.chi_0);
  set_product(p.C_d_inverse_t, p.chi_0, p.kappa_l);

  p.g_Y.setZero();
  p.g_V.setZero();
  add_transposed_product(p.Res_Y, p.nu, p.g_Y);
  add_transposed_product(p.L_Y, p.kappa_l, p.g_Y);
  add_transposed_product(p.Res_V, p.nu, p.g_V);
  add_transposed_product(p.L_V, p.kappa_l, p.g_V);
  if (m > 0) {
    add_transposed_product(p.F_Y, p.adjoint.tail(m), p.g_Y);
    add_transposed_product(p.F_V, p.adjoint.tail(m), p.g_V);
  }

  p.D_loops.setZero();
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const int row = 2 * l;
    const Vec2Of<S> force = p.loop_force.template segment<2>(row),
                    kappa = p.kappa_l.template segment<2>(row);
    add_constraint_hessian(tree.loops[l].a, force, kappa, 1.0, p.A, false, row, p.D_loops, p);
    add_constraint_hessian(tree.loops[l].b, force, kappa, -1.0, p.A, false, row, p.D_loops, p);
  }
  add_dependent_curvature(tree, p);
}

/// Subtracts what is by (Y, V) twice, chained to (q, v), from H.
template <class S>
void subtract_chained(const dynamics::AbsoluteTree& tree, EquationsPointOf<S>& p, MatrixOf<S>& H) {
  const int n = tree.n;
  const MatrixOf<S>&G = p.motion.G, &X = p.motion.X;

  p.GV.setZero();
  add_sparse_transposed_times<S>(G, tree.G_pattern, 1.0, p.YV, p.GV);  // G^T YV
  p.qv.setZero();
  add_times_sparse<S>(p.GV, X, tree.X_pattern, 1.0, p.qv);
  p.qq = p.qv + p.qv.transpose();
  p.qv.setZero();
  add_times_sparse<S>(p.GV, G, tree.G_pattern, 1.0, p.qv);

  p.GY.setZero();
  add_sparse_transposed_times<S>(G, tree.G_pattern, 1.0, p.YY, p.GY);
  add_times_sparse<S>(p.GY, G, tree.G_pattern, 1.0, p.qq);
  p.XV.setZero();
  add_sparse_transposed_times<S>(X, tree.X_pattern, 1.0, p.VV, p.XV);
  add_times_sparse<S>(p.XV, X, tree.X_pattern, 1.0, p.qq);
  add_times_sparse<S>(p.XV, G, tree.G_pattern, 1.0, p.qv);

  p.GV.setZero();
  add_sparse_transposed_times<S>(G, tree.G_pattern, 1.0, p.VV, p.GV);
  p.vv.setZero();
  add_times_sparse<S>(p.GV, G, tree.G_pattern, 1.0, p.vv);

  H.topLeftCorner(n, n) -= p.qq;
  H.block(0, n, n, n) -= p.qv;
  H.block(n, 0, n, n) -= p.qv.transpose();
  H.block(n, n, n, n) -= p.vv;
}

/// Subtracts what is by Y and by accelerations or forces, which Z takes to (q, v, u): with l the
/// loops' forces, nu . r has the cross terms YA dA + D_f df + D_l dl.
template <class S>
void subtract_moved(const dynamics::AbsoluteTree& tree, EquationsPointOf<S>& p, MatrixOf<S>& H) {
  const int n = tree.n, m = count_of(p.force);
  p.GY.setZero();
  add_sparse_transposed_times<S>(p.motion.G, tree.G_pattern, 1.0, p.YA, p.GY);
  p.left.setZero();
  add_times_sparse<S>(p.GY, p.motion.G, tree.G_pattern, 1.0, p.left.leftCols(n));
  add_sparse_transposed_times<S>(p.motion.G, tree.G_pattern, 1.0, p.D_feet, p.left.rightCols(m));

  p.nw.setZero();
  if (tree.nd > 0) {
    // dl = C_d^-T (balance + P_d^T M G da - (J_f P_d)^T df)
    p.GD.setZero();
    add_sparse_transposed_times<S>(p.motion.G, tree.G_pattern, 1.0, p.D_loops, p.GD);
    set_product(p.GD, p.C_d_inverse_t, p.GAP);
    add_product(p.GAP, p.PMG, p.left.leftCols(n));
    if (m > 0) subtract_product(p.GAP, p.JP_t, p.left.rightCols(m));
    add_product(p.GAP, p.balance, p.nw.leftCols(2 * n));

    // dA = G da - P_d loop_w
    p.GA.setZero();
    add_times_sparse<S>(p.GY, tree.P_d, tree.P_d_pattern, 1.0, p.GA);
    subtract_product(p.GA, p.loop_w, p.nw.leftCols(2 * n));
  }
  add_product(p.left, p.Z, p.nw);

  H.topRows(n) -= p.nw;
  H.leftCols(n) -= p.nw.transpose();
}

}  // namespace

template <class S>
void Equations::add_hessian(VectorArg<S> mu, EquationsPointOf<S>& p, MatrixOf<S>& H) const {
  p.adjoint = mu;
  p.saddle.solve_transposed(p.adjoint);
  p.nu.setZero();
  add_sparse_times<S>(p.motion.G, tree_.G_pattern, 1.0, p.adjoint.head(tree_.n), p.nu);
  p.YY.setZero();
  p.YV.setZero();
  p.VV.setZero();
  p.YA.setZero();

  add_body_hessian(tree_, p);
  if (!p.impact) add_drag_hessian(p);
  add_feet_hessian(tree_, p);
  if (tree_.nd > 0) add_loops_hessian(tree_, p);

  subtract_chained(tree_, p, H);
  subtract_moved(tree_, p, H);
}

template void Equations::add_hessian<double>(VectorArg<double>, EquationsPointOf<double>&,
                                             MatrixOf<double>&) const;
template void Equations::add_hessian<Lanes>(VectorArg<Lanes>, EquationsPointOf<Lanes>&,
                                            MatrixOf<Lanes>&) const;

}  // namespace jaculus::components
