#include "jaculus/components/equations.h"

#include <cmath>

#include "jaculus/core/small_product.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::components {

namespace {

/// out += scale * a^T b over the sparse columns of two points.
void add_outer(const dynamics::PointColumns& a, const dynamics::PointColumns& b, double scale,
               Matrix& out) {
  for (int j = 0; j < b.count; ++j) {
    const double bx = scale * b.x[j], bz = scale * b.z[j];
    double* column = out.col(b.index[j]).data();
    for (int i = 0; i < a.count; ++i) column[a.index[i]] += a.x[i] * bx + a.z[i] * bz;
  }
}

void copy_pattern(const dynamics::PointColumns& from, dynamics::PointColumns& to) {
  to.count = from.count;
  for (int k = 0; k < from.count; ++k) {
    to.index[k] = from.index[k];
    to.x[k] = to.z[k] = 0.0;
  }
}

void put_rows(const dynamics::PointColumns& c, int row, Matrix& out) {
  for (int k = 0; k < c.count; ++k) {
    out(row, c.index[k]) += c.x[k];
    out(row + 1, c.index[k]) += c.z[k];
  }
}

/// Columns of d(pdd)/dY = D(A) + E(V) and d(pdd)/dV = 2 D(V); an impact has no terms in the rates.
void acceleration_columns(const dynamics::Path& path, const Vector& A, EquationsPoint& p) {
  copy_pattern(p.J, p.PY);
  copy_pattern(p.J, p.PV);
  dynamics::add_D(path, p.motion.pose, A, 1.0, p.PY);
  if (p.impact) return;
  dynamics::add_E(path, p.motion.pose, p.motion.V, 1.0, p.PY);
  dynamics::add_D(path, p.motion.pose, p.motion.V, 2.0, p.PV);
}

Vec2 acceleration(const dynamics::Path& path, const EquationsPoint& p, const Vector& A) {
  const Vec2 linear = p.J.times(A);
  return p.impact ? linear : Vec2(linear + dynamics::quadratic(path, p.motion.pose, p.motion.V));
}

/// The system of the accelerations, its right-hand side without the inputs.
void assemble(const dynamics::AbsoluteTree& tree, EquationsPoint& p) {
  const int n = tree.n, m = count_of(p.force);
  const Matrix& G = p.motion.G;
  p.J_f.setZero();
  for (int k = 0; k < m / 2; ++k) {
    const dynamics::Path& path = tree.feet[p.feet[k]];
    dynamics::jacobian_columns(path, p.motion.pose, p.J);
    put_rows(p.J, 2 * k, p.J_f);
    p.rhs0.segment<2>(n + 2 * k) = -acceleration(path, p, p.impact ? p.motion.V : p.motion.gamma);
  }
  set_product(p.M, G, p.MG);
  p.K.topLeftCorner(n, n) = tree.armature;
  add_product(p.motion.Gt, p.MG, p.K.topLeftCorner(n, n));
  set_product(p.J_f, G, p.K.bottomLeftCorner(m, n));
  p.K.topRightCorner(n, m) = -p.K.bottomLeftCorner(m, n).transpose();
  p.K.bottomRightCorner(m, m).setZero();
  p.rhs0.head(n) = -G.transpose().lazyProduct(p.r);
}

}  // namespace

bool Equations::evaluate(const Eigen::Ref<const Vector>& q, const Eigen::Ref<const Vector>& v,
                         const Eigen::Ref<const Vector>& u, EquationsPoint& p) const {
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
  p.rhs0.head(tree_.n) += tree_.input_map.lazyProduct(u);
  add_friction(p);
  if (!solve_system(p)) return false;
  p.A_feet = p.A;
  return true;
}

bool Equations::evaluate_impact(const Eigen::Ref<const Vector>& q,
                                const Eigen::Ref<const Vector>& v, EquationsPoint& p) const {
  if (!dynamics::set_configuration(tree_, q, p.motion)) return false;
  p.q = q;
  p.v = v;
  p.impact = true;
  p.motion.V = p.motion.G.lazyProduct(v);
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

bool Equations::solve_system(EquationsPoint& p) const {
  p.lu.compute(p.K);
  p.adjoint = p.lu.solve(p.rhs0);
  if (!p.adjoint.allFinite()) return false;
  p.a = p.adjoint.head(tree_.n);
  p.force = p.adjoint.tail(p.force.size());
  p.A = p.motion.G.lazyProduct(p.a);
  p.A += p.motion.gamma;
  return true;
}

namespace {

/// Derivatives of the residual r and of the feet's acceleration by Y and V, at the solution.
void residual_derivatives(const dynamics::AbsoluteTree& tree, EquationsPoint& p) {
  for (std::size_t b = 0; b < tree.com.size(); ++b) {
    if (tree.mass[b] == 0.0) continue;
    const dynamics::Path& path = tree.com[b];

    dynamics::jacobian_columns(path, p.motion.pose, p.J);
    acceleration_columns(path, p.A, p);
    add_outer(p.J, p.PY, tree.mass[b], p.Res_Y);
    add_outer(p.J, p.PV, tree.mass[b], p.Res_V);
    const Vec2 weight = acceleration(path, p, p.A) + Vec2(0.0, p.impact ? 0.0 : tree.gravity);
    dynamics::add_H(path, p.motion.pose, tree.mass[b] * weight, p.Res_Y);
  }

  for (int k = 0; k < count_of(p.feet); ++k) {
    const dynamics::Path& path = tree.feet[p.feet[k]];
    const int row = 2 * k;
    dynamics::jacobian_columns(path, p.motion.pose, p.J);
    acceleration_columns(path, p.A_feet, p);
    put_rows(p.PY, row, p.F_Y);
    put_rows(p.impact ? p.J : p.PV, row, p.F_V);
    dynamics::add_H(path, p.motion.pose, -p.force.segment<2>(row), p.Res_Y);
  }
}

/// Loop forces from the balance of the dependent joints, and what they add to dr/dY.
void add_loop_forces(const dynamics::AbsoluteTree& tree, EquationsPoint& p) {
  if (tree.nd == 0) return;
  // r at A: r(gamma) + M (A - gamma) - J_f^T f.
  p.g_Y = p.A - p.motion.gamma;
  p.g_V = p.M.lazyProduct(p.g_Y);
  p.g_V += p.r;
  p.g_V -= p.J_f.transpose().lazyProduct(p.force);
  p.kappa_l = tree.P_d.transpose().lazyProduct(p.g_V);
  p.loop_force = p.motion.C_d_inverse.transpose().lazyProduct(p.kappa_l);
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2 force = p.loop_force.segment<2>(2 * l);
    dynamics::add_H(tree.loops[l].a, p.motion.pose, -force, p.Res_Y);
    dynamics::add_H(tree.loops[l].b, p.motion.pose, force, p.Res_Y);
  }
}

/// out = (first_Y G + first_V X | first_V G | 0) over (q, v, u).
void chain_to_state(const EquationsPoint& p, const Matrix& first_Y, const Matrix& first_V,
                    Eigen::Ref<Matrix> out) {
  const int n = count_of(p.a);
  set_product(first_Y, p.motion.G, out.leftCols(n));
  add_product(first_V, p.motion.X, out.leftCols(n));
  set_product(first_V, p.motion.G, out.middleCols(n, n));
  out.rightCols(out.cols() - 2 * n).setZero();
}

}  // namespace

void Equations::differentiate(EquationsPoint& p) const {
  const int n = tree_.n, m = count_of(p.force);
  dynamics::set_rate_sensitivity(tree_, p.motion);
  p.Res_Y.setZero();
  p.Res_V.setZero();
  p.F_Y.setZero();
  p.F_V.setZero();
  residual_derivatives(tree_, p);
  if (!p.impact) add_drag_derivatives(p);
  add_loop_forces(tree_, p);

  p.Gamma.setZero();
  chain_to_state(p, p.Res_Y, p.Res_V, p.Nw);
  if (tree_.nd > 0) {
    dynamics::loop_acceleration_derivatives(tree_, p.motion, p.A, p.impact, p.L_Y, p.L_V);
    chain_to_state(p, p.L_Y, p.L_V, p.d_loop_force);
    set_product(p.motion.C_d_inverse, p.d_loop_force, p.loop_w);
    subtract_product(tree_.P_d, p.loop_w, p.Gamma);
    set_product(p.M, tree_.P_d, p.MP_d);
    subtract_product(p.MP_d, p.loop_w, p.Nw);  // + M Gamma
  }
  p.rhs.topRows(n).setZero();
  subtract_product(p.motion.Gt, p.Nw, p.rhs.topRows(n));
  if (!p.impact) p.rhs.topRows(n).rightCols(inputs()) += tree_.input_map;
  if (!p.impact) add_friction_derivatives(p);
  if (m > 0) {
    chain_to_state(p, p.F_Y, p.F_V, p.rhs.bottomRows(m));
    add_product(p.J_f, p.Gamma, p.rhs.bottomRows(m));
    p.rhs.bottomRows(m) *= -1.0;
  }
  p.Z = p.lu.solve(p.rhs);

  p.dA = p.Gamma;
  add_product(p.motion.G, p.Z.topRows(n), p.dA);
  if (tree_.nd > 0) {
    // Balance of the dependent joints: C_d^T dl = P_d^T (M dA - J_f^T df + R dw).
    add_product(p.MG, p.Z.topRows(n), p.Nw);  // Nw has R dw and M Gamma
    p.J_ft = p.J_f.transpose();
    if (m > 0) subtract_product(p.J_ft, p.Z.bottomRows(m), p.Nw);
    set_product(p.P_dt, p.Nw, p.S_Y.topRows(tree_.nd));
    p.d_loop_force = p.motion.C_d_inverse.transpose().lazyProduct(p.S_Y.topRows(tree_.nd));
  }
}

namespace {

/// Second derivatives of nu . (body terms).
void add_body_hessian(const dynamics::AbsoluteTree& tree, EquationsPoint& p) {
  const dynamics::Pose& pose = p.motion.pose;
  const Vector& V = p.motion.V;
  for (std::size_t b = 0; b < tree.com.size(); ++b) {
    const double mass = tree.mass[b];
    if (mass == 0.0) continue;
    const dynamics::Path& path = tree.com[b];

    dynamics::jacobian_columns(path, pose, p.J);
    acceleration_columns(path, p.A, p);
    copy_pattern(p.J, p.Dnu);
    dynamics::add_D(path, pose, p.nu, 1.0, p.Dnu);
    const Vec2 weight =
        mass * (acceleration(path, p, p.A) + Vec2(0.0, p.impact ? 0.0 : tree.gravity));
    const Vec2 shift = mass * p.J.times(p.nu);

    add_outer(p.PY, p.Dnu, mass, p.YY);
    add_outer(p.Dnu, p.PY, mass, p.YY);
    dynamics::add_T(path, pose, weight, p.nu, p.YY);
    dynamics::add_T(path, pose, shift, p.A, p.YY);
    add_outer(p.Dnu, p.J, mass, p.YA);
    dynamics::add_H(path, pose, shift, p.YA);

    if (p.impact) continue;
    dynamics::add_F(path, pose, shift, V, p.YY);
    add_outer(p.Dnu, p.PV, mass, p.YV);
    dynamics::add_T(path, pose, 2.0 * shift, V, p.YV);
    dynamics::add_H(path, pose, 2.0 * shift, p.VV);
  }
}

/// Second derivatives of kappa . (point's acceleration at A) - force . (virtual displacement), and
/// d(force) . D(nu) into S_Y. `jump`: kappa . J A alone, where A holds the rates before an impact
/// as well.
void add_constraint_hessian(const dynamics::Path& path, const Vec2& force, const Vec2& kappa,
                            double sign, const Vector& A, bool jump, const Matrix& d_force, int row,
                            EquationsPoint& p) {
  const dynamics::Pose& pose = p.motion.pose;

  const Vec2 k = sign * kappa;
  dynamics::add_T(path, pose, -sign * force, p.nu, p.YY);
  dynamics::add_T(path, pose, k, A, p.YY);
  dynamics::add_H(path, pose, k, p.YA);
  if (jump) dynamics::add_H(path, pose, k, p.YV);
  if (!p.impact) {
    dynamics::add_F(path, pose, k, p.motion.V, p.YY);
    dynamics::add_T(path, pose, 2.0 * k, p.motion.V, p.YV);
    dynamics::add_H(path, pose, 2.0 * k, p.VV);
  }

  dynamics::jacobian_columns(path, pose, p.J);
  copy_pattern(p.J, p.Dnu);
  dynamics::add_D(path, pose, p.nu, -sign, p.Dnu);
  for (int c = 0; c < p.Dnu.count; ++c) {
    p.S_Y.row(p.Dnu.index[c]) += p.Dnu.x[c] * d_force.row(row) + p.Dnu.z[c] * d_force.row(row + 1);
  }
}

/// Multipliers that make the sum stationary in the dependent joints' rates and values, and their
/// curvature.
void add_dependent_curvature(const dynamics::AbsoluteTree& tree, EquationsPoint& p) {
  dynamics::Motion& m = p.motion;
  p.chi_0 = tree.P_d.transpose().lazyProduct(p.g_V);
  p.chi_1 = -m.C_d_inverse.transpose().lazyProduct(p.chi_0);

  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2 chi = p.chi_1.segment<2>(2 * l);
    for (int side = 0; side < 2; ++side) {
      const dynamics::Path& path = side == 0 ? tree.loops[l].a : tree.loops[l].b;
      const Vec2 w = side == 0 ? chi : Vec2(-chi);
      dynamics::jacobian_columns(path, m.pose, p.J);
      copy_pattern(p.J, p.Dnu);
      dynamics::add_D(path, m.pose, m.V, 1.0, p.Dnu);
      p.Dnu.add_transposed(w, 1.0, p.g_Y);
      dynamics::add_T(path, m.pose, w, m.V, p.YY);
      dynamics::add_H(path, m.pose, w, p.YV);
    }
  }

  p.kappa_l = tree.P_d.transpose().lazyProduct(p.g_Y);
  p.chi_0 = -m.C_d_inverse.transpose().lazyProduct(p.kappa_l);
  for (int l = 0; l < count_of(tree.loops); ++l) {
    const Vec2 chi = p.chi_0.segment<2>(2 * l);
    dynamics::add_H(tree.loops[l].a, m.pose, chi, p.YY);
    dynamics::add_H(tree.loops[l].b, m.pose, -chi, p.YY);
  }
}

/// Subtracts the second derivatives, chained to (q, v, u), from H.
void subtract_chained(const dynamics::AbsoluteTree& tree, EquationsPoint& p, Matrix& H) {
  const int n = tree.n;
  const Matrix &G = p.motion.G, &X = p.motion.X, &Gt = p.motion.Gt;

  set_product(p.YY, G, p.Nn);
  add_product(p.YV, X, p.Nn);
  p.NN2 = p.YV.transpose();
  set_product(p.NN2, G, p.Nn2);
  add_product(p.VV, X, p.Nn2);
  set_product(Gt, p.Nn, p.qq);
  add_product(p.motion.Xt, p.Nn2, p.qq);
  set_product(Gt, p.Nn2, p.qv);  // by (v, q)
  set_product(p.VV, G, p.Nn);

  H.topLeftCorner(n, n) -= p.qq;
  H.block(0, n, n, n) -= p.qv.transpose();
  H.block(n, 0, n, n) -= p.qv;
  subtract_product(Gt, p.Nn, H.block(n, n, n, n));

  add_product(p.YA, p.dA, p.S_Y);
  set_product(Gt, p.S_Y, p.nw);
  H.topRows(n) -= p.nw;
  H.leftCols(n) -= p.nw.transpose();
}

}  // namespace

void Equations::add_hessian(const Eigen::Ref<const Vector>& mu, EquationsPoint& p,
                            Matrix& H) const {
  const int n = tree_.n, m = count_of(p.force);

  // K^T y = mu with K = P^T L U; Eigen's own transposed solve would copy the factors.
  p.adjoint = mu;
  p.lu.matrixLU().triangularView<Eigen::Upper>().transpose().solveInPlace(p.adjoint);
  p.lu.matrixLU().triangularView<Eigen::UnitLower>().transpose().solveInPlace(p.adjoint);
  p.rhs0.swap(p.adjoint);
  p.adjoint.noalias() = p.lu.permutationP().transpose() * p.rhs0;

  p.nu = p.motion.G.lazyProduct(p.adjoint.head(n));
  p.YY.setZero();
  p.YV.setZero();
  p.VV.setZero();
  p.YA.setZero();
  p.S_Y.setZero();

  add_body_hessian(tree_, p);
  if (!p.impact) add_drag_hessian(p);

  for (int k = 0; k < count_of(p.feet); ++k) {
    const int row = 2 * k;
    add_constraint_hessian(tree_.feet[p.feet[k]], p.force.segment<2>(row),
                           p.adjoint.segment<2>(n + row), 1.0, p.A_feet, p.impact, p.Z, n + row, p);
  }

  if (tree_.nd > 0) {
    p.g_V = p.M.lazyProduct(p.nu);
    if (m > 0) p.g_V += p.J_f.transpose().lazyProduct(p.adjoint.tail(m));
    p.chi_0 = tree_.P_d.transpose().lazyProduct(p.g_V);

    p.kappa_l = -p.motion.C_d_inverse.transpose().lazyProduct(p.chi_0);
    p.g_Y = p.Res_Y.transpose().lazyProduct(p.nu);
    p.g_Y += p.L_Y.transpose().lazyProduct(p.kappa_l);
    p.g_V = p.Res_V.transpose().lazyProduct(p.nu);
    p.g_V += p.L_V.transpose().lazyProduct(p.kappa_l);

    if (m > 0) {
      p.g_Y += p.F_Y.transpose().lazyProduct(p.adjoint.tail(m));
      p.g_V += p.F_V.transpose().lazyProduct(p.adjoint.tail(m));
    }

    for (int l = 0; l < count_of(tree_.loops); ++l) {
      const int row = 2 * l;
      const Vec2 force = p.loop_force.segment<2>(row), kappa = p.kappa_l.segment<2>(row);
      add_constraint_hessian(tree_.loops[l].a, force, kappa, 1.0, p.A, false, p.d_loop_force, row,
                             p);
      add_constraint_hessian(tree_.loops[l].b, force, kappa, -1.0, p.A, false, p.d_loop_force, row,
                             p);
    }
    add_dependent_curvature(tree_, p);
  }

  subtract_chained(tree_, p, H);
  if (!p.impact) add_friction_hessian(p, H);
}

}  // namespace jaculus::components
