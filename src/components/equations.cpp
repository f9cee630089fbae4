#include "jaculus/components/equations.h"

#include "components/point_terms.h"
#include "jaculus/core/small_product.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::components {

namespace {

/// The system of the accelerations, its right-hand side (in p.adjoint) without the inputs.
template <class S>
JACULUS_WIDE void assemble(const dynamics::AbsoluteTree& tree, EquationsPointOf<S>& p) {
  const int n = tree.n, m = count_of(p.force);
  const MatrixOf<S>& G = p.motion.G;

  p.J_f.setZero();
  for (int k = 0; k < m / 2; ++k) {
    const dynamics::Path& path = tree.feet[p.feet[k]];
    dynamics::jacobian_columns(path, p.motion.pose, p.J);
    put_rows(p.J, 2 * k, p.J_f);
    const Vec2Of<S> at_rest = acceleration(path, p, p.impact ? p.motion.V : p.motion.gamma);
    p.adjoint[n + 2 * k] = -at_rest.x();
    p.adjoint[n + 2 * k + 1] = -at_rest.y();
  }
  p.J_G.setZero();
  add_times_sparse<S>(p.J_f, G, tree.G_pattern, 1.0, p.J_G);

  p.MG.setZero();
  add_times_sparse<S>(p.M, G, tree.G_pattern, 1.0, p.MG);
  for (int i = 0; i < count_of(tree.armature); ++i) p.mass.data()[i] = S(tree.armature.data()[i]);
  add_sparse_transposed_times<S>(G, tree.G_pattern, 1.0, p.MG, p.mass);

  p.adjoint.head(n).setZero();
  add_sparse_transposed_times<S>(G, tree.G_pattern, -1.0, p.r, p.adjoint.head(n));
}

template <class S>
bool finite(const VectorOf<S>& x) {
  for (int i = 0; i < count_of(x); ++i)
    if (!all_finite(x[i])) return false;
  return true;
}

}  // namespace

template <class S>
bool Equations::evaluate(VectorArg<S> q, VectorArg<S> v, VectorArg<S> u,
                         EquationsPointOf<S>& p) const {
  if (!dynamics::set_configuration(tree_, q, p.motion)) return false;
  p.q = q;
  p.v = v;
  p.impact = false;
  dynamics::set_rates(tree_, v, p.motion);
  p.M.setZero();
  p.r.setZero();
  dynamics::add_bodies(tree_, p.motion, p.motion.gamma, p.M, p.r, p.J);
  add_drag(p);
  assemble(tree_, p);
  for (int i = 0; i < inputs(); ++i)
    for (int k = 0; k < tree_.n; ++k)
      if (tree_.input_map(k, i) != 0.0) p.adjoint[k] += S(tree_.input_map(k, i)) * u[i];
  add_friction(p);
  if (!solve_system(p)) return false;
  p.A_feet = p.A;
  return true;
}

template <class S>
bool Equations::evaluate_impact(VectorArg<S> q, VectorArg<S> v, EquationsPointOf<S>& p) const {
  if (!dynamics::set_configuration(tree_, q, p.motion)) return false;
  p.q = q;
  p.v = v;
  p.impact = true;
  dynamics::set_rates(tree_, v, p.motion);
  p.motion.gamma.setZero();
  p.M.setZero();
  p.r.setZero();
  dynamics::add_bodies(tree_, p.motion, p.motion.gamma, p.M, p.r, p.J);
  p.r.setZero();  // no force counts beside an impact
  assemble(tree_, p);
  if (!solve_system(p)) return false;
  p.A_feet = p.A + p.motion.V;
  return true;
}

template <class S>
bool Equations::solve_system(EquationsPointOf<S>& p) const {
  p.saddle.factorize(p.mass, p.J_G);
  p.saddle.solve(p.adjoint);
  if (!finite(p.adjoint)) return false;
  p.a = p.adjoint.head(tree_.n);
  p.force = p.adjoint.tail(p.force.size());
  p.A = p.motion.gamma;
  add_sparse_times<S>(p.motion.G, tree_.G_pattern, 1.0, p.a, p.A);
  return true;
}

namespace {

/// Derivatives of the residual r and of the feet's acceleration by Y and V, at the solution.
template <class S>
JACULUS_WIDE void residual_derivatives(const dynamics::AbsoluteTree& tree, EquationsPointOf<S>& p) {
  for (std::size_t b = 0; b < tree.com.size(); ++b) {
    if (tree.mass[b] == 0.0) continue;
    const dynamics::Path& path = tree.com[b];

    dynamics::jacobian_columns(path, p.motion.pose, p.J);
    acceleration_columns(path, p.A, p);
    add_outer(p.J, 0, p.PY, kTranslation, tree.mass[b], p.Res_Y);
    if (!p.impact) add_outer(p.J, 0, p.PV, kTranslation, tree.mass[b], p.Res_V);
    dynamics::add_H(path, p.motion.pose, weight(tree, b, p), p.Res_Y);
  }

  for (int k = 0; k < count_of(p.feet); ++k) {
    const dynamics::Path& path = tree.feet[p.feet[k]];
    const int row = 2 * k;
    dynamics::jacobian_columns(path, p.motion.pose, p.J);
    acceleration_columns(path, p.A_feet, p);
    put_rows(p.PY, row, p.F_Y);
    put_rows(p.impact ? p.J : p.PV, row, p.F_V);
    const Vec2Of<S> against(-p.force[row], -p.force[row + 1]);
    dynamics::add_H(path, p.motion.pose, against, p.Res_Y);
  }
}

/// Loop forces from the balance of the dependent joints, and what they add to dr/dY.
template <class S>
JACULUS_WIDE void add_loop_forces(const dynamics::AbsoluteTree& tree, EquationsPointOf<S>& p) {
  // r at A: r(gamma) + M (A - gamma) - J_f^T f.
  p.g_Y = p.A - p.motion.gamma;
  p.g_V = p.r;
  add_product(p.M, p.g_Y, p.g_V);
  for (int k = 0; k < count_of(p.force); ++k)
    for (int i = 0; i < tree.N; ++i) p.g_V[i] -= p.J_f(k, i) * p.force[k];
  p.kappa_l.setZero();
  add_sparse_transposed_times<S>(tree.P_d, tree.P_d_pattern, 1.0, p.g_V, p.kappa_l);
  p.C_d_inverse_t = p.motion.C_d_inverse.transpose();
  set_product(p.C_d_inverse_t, p.kappa_l, p.loop_force);

  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2Of<S> force = p.loop_force.template segment<2>(2 * l), against = -force;
    dynamics::add_H(tree.loops[l].a, p.motion.pose, against, p.Res_Y);
    dynamics::add_H(tree.loops[l].b, p.motion.pose, force, p.Res_Y);
  }
}

/// out += sign (first_Y G + first_V X | first_V G) over (q, v).
template <class S>
void chain_to_state(const dynamics::AbsoluteTree& tree, const EquationsPointOf<S>& p,
                    const MatrixOf<S>& first_Y, const MatrixOf<S>& first_V, double sign,
                    std::type_identity_t<RefOf<S>> out) {
  const int n = tree.n;
  add_times_sparse<S>(first_Y, p.motion.G, tree.G_pattern, sign, out.leftCols(n));
  add_times_sparse<S>(first_V, p.motion.X, tree.X_pattern, sign, out.leftCols(n));
  add_times_sparse<S>(first_V, p.motion.G, tree.G_pattern, sign, out.middleCols(n, n));
}

/// What the dependent joints' accelerations add to the right-hand side of Z, in (q, v).
template <class S>
void add_dependent_motion(const dynamics::AbsoluteTree& tree, EquationsPointOf<S>& p) {
  const ColumnPattern& pattern = tree.P_d_pattern;
  const int n = tree.n, m = count_of(p.force);

  dynamics::loop_acceleration_derivatives(tree, p.motion, p.A, p.impact, p.L_Y, p.L_V);
  p.d_loops.setZero();
  chain_to_state(tree, p, p.L_Y, p.L_V, 1.0, p.d_loops);
  set_product(p.motion.C_d_inverse, p.d_loops, p.loop_w);

  p.PMG.setZero();
  add_sparse_transposed_times<S>(tree.P_d, pattern, 1.0, p.MG, p.PMG);
  p.PMG_t = p.PMG.transpose();
  add_product(p.PMG_t, p.loop_w, p.Z.topLeftCorner(n, 2 * n));
  if (m > 0) {
    p.JP.setZero();
    add_times_sparse<S>(p.J_f, tree.P_d, pattern, 1.0, p.JP);
    p.JP_t = p.JP.transpose();
    add_product(p.JP, p.loop_w, p.Z.bottomLeftCorner(m, 2 * n));
  }

  // Balance of the dependent joints: C_d^T dl = P_d^T (M dA - J_f^T df + dr), of which here what
  // goes with neither da nor df.
  p.balance.setZero();
  add_sparse_transposed_times<S>(tree.P_d, pattern, 1.0, p.chain, p.balance);
  p.YA.leftCols(tree.nd).setZero();
  add_times_sparse<S>(p.M, tree.P_d, pattern, 1.0, p.YA.leftCols(tree.nd));
  p.PMP.setZero();
  add_sparse_transposed_times<S>(tree.P_d, pattern, 1.0, p.YA.leftCols(tree.nd), p.PMP);
  subtract_product(p.PMP, p.loop_w, p.balance);
}

}  // namespace

template <class S>
void Equations::differentiate(EquationsPointOf<S>& p) const {
  const int n = tree_.n, m = count_of(p.force);
  dynamics::set_rate_sensitivity(tree_, p.motion);
  p.Res_Y.setZero();
  p.Res_V.setZero();
  p.F_Y.setZero();
  p.F_V.setZero();
  residual_derivatives(tree_, p);
  if (!p.impact) add_drag_derivatives(p);
  if (tree_.nd > 0) add_loop_forces(tree_, p);

  p.chain.setZero();
  chain_to_state(tree_, p, p.Res_Y, p.Res_V, 1.0, p.chain);
  p.Z.setZero();
  add_sparse_transposed_times<S>(p.motion.G, tree_.G_pattern, -1.0, p.chain,
                                 p.Z.topLeftCorner(n, 2 * n));
  if (m > 0) chain_to_state(tree_, p, p.F_Y, p.F_V, -1.0, p.Z.bottomRows(m));
  if (tree_.nd > 0) add_dependent_motion(tree_, p);
  if (!p.impact) {
    for (int i = 0; i < inputs(); ++i)
      for (int k = 0; k < n; ++k) p.Z(k, 2 * n + i) = S(tree_.input_map(k, i));
    add_friction_derivatives(p);
  }
  p.saddle.solve(p.Z);
}

#define JACULUS_INSTANTIATE(S)                                                                  \
  template bool Equations::evaluate<S>(VectorArg<S>, VectorArg<S>, VectorArg<S>,                \
                                       EquationsPointOf<S>&) const;                             \
  template bool Equations::evaluate_impact<S>(VectorArg<S>, VectorArg<S>, EquationsPointOf<S>&) \
      const;                                                                                    \
  template void Equations::differentiate<S>(EquationsPointOf<S>&) const;

JACULUS_INSTANTIATE(double)
JACULUS_INSTANTIATE(Lanes)
#undef JACULUS_INSTANTIATE

}  // namespace jaculus::components
