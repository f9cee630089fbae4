// Drag in the equations of motion. With the pivot's Jacobian J, the normal e' = dR/dphi e and the
// tail's direction e = R direction,
//   s = e' . (J V - wind),   sigma = e' . J nu   (the same with the virtual motion nu),
// drag adds -(force(s, omega) sigma + moment(s, omega) nu_phi) to nu . r. Derivatives of s:
//   ds/dY = e' . D(V) - e . (J V - wind) at phi,      ds/dV = J^T e',
//   d2s/dY2 = T(e', V) with the mixed terms -e . D(V) at (., phi) and -e' . (J V - wind) at
//             (phi, phi),
//   d2s/dYdV = H(e') with -J^T e in row phi.

#include "jaculus/components/equations.h"

namespace jaculus::components {

Vec2 Equations::drag_normal(const model::PlanarDrag& drag, const EquationsPoint& p,
                            Vec2& along) const {
  const int phi = dynamics::AbsoluteTree::angle_index(drag.body);
  const double c = p.motion.pose.cosine[phi], s = p.motion.pose.sine[phi];
  along = Vec2(c * drag.direction.x() + s * drag.direction.y(),
               -s * drag.direction.x() + c * drag.direction.y());
  return {along.y(), -along.x()};
}

namespace {

Vec2 pivot_velocity(const dynamics::Path& path, EquationsPoint& p) {
  dynamics::jacobian_columns(path, p.motion.pose, p.J);
  return p.J.times(p.motion.V);
}

/// Gradients of s by Y (into g_Y) and of s by V (into g_V); p.J must hold the pivot's columns.
void flow_gradients(const dynamics::Path& path, int phi, const Vec2& normal, const Vec2& along,
                    const Vec2& air, const Vector& X, EquationsPoint& p, Vector& by_Y,
                    Vector& by_V) {
  p.Dnu.count = p.J.count;
  for (int k = 0; k < p.J.count; ++k) {
    p.Dnu.index[k] = p.J.index[k];
    p.Dnu.x[k] = p.Dnu.z[k] = 0.0;
  }
  dynamics::add_D(path, p.motion.pose, X, 1.0, p.Dnu);
  by_Y.setZero();
  p.Dnu.add_transposed(normal, 1.0, by_Y);
  by_Y[phi] -= along.dot(air);
  by_V.setZero();
  p.J.add_transposed(normal, 1.0, by_V);
}

/// out += scale * d2(e' . (J X - wind))/dY2; p.Dnu must hold D(X).
void add_flow_YY(const dynamics::Path& path, int phi, const Vec2& normal, const Vec2& along,
                 const Vec2& air, const Vector& X, double scale, EquationsPoint& p, Matrix& out) {
  dynamics::add_T(path, p.motion.pose, scale * normal, X, out);
  for (int k = 0; k < p.Dnu.count; ++k) {
    const double cross = -scale * (along.x() * p.Dnu.x[k] + along.y() * p.Dnu.z[k]);
    out(p.Dnu.index[k], phi) += cross;
    out(phi, p.Dnu.index[k]) += cross;
  }
  out(phi, phi) -= scale * normal.dot(air);
}

/// out += scale * d2(e' . J X)/dY dX.
void add_flow_YV(const dynamics::Path& path, int phi, const Vec2& normal, const Vec2& along,
                 double scale, EquationsPoint& p, Matrix& out) {
  dynamics::add_H(path, p.motion.pose, scale * normal, out);
  for (int k = 0; k < p.J.count; ++k) {
    out(phi, p.J.index[k]) -= scale * (along.x() * p.J.x[k] + along.y() * p.J.z[k]);
  }
}

}  // namespace

void Equations::add_drag(EquationsPoint& p) const {
  for (const model::PlanarDrag& drag : model_.drags) {
    if (drag.kind == model::DragKind::none || drag.coefficient == 0.0) continue;
    const int phi = dynamics::AbsoluteTree::angle_index(drag.body);
    Vec2 along;
    const Vec2 normal = drag_normal(drag, p, along);
    const Vec2 air = pivot_velocity(tree_.origin[drag.body], p) - drag.wind_W;
    const DragLoad load = drag_load(drag, normal.dot(air), p.motion.V[phi], smoothing_);
    p.J.add_transposed(normal, -load.force, p.r);
    p.r[phi] -= load.moment;
  }
}

void Equations::add_drag_derivatives(EquationsPoint& p) const {
  for (const model::PlanarDrag& drag : model_.drags) {
    if (drag.kind == model::DragKind::none || drag.coefficient == 0.0) continue;
    const dynamics::Path& path = tree_.origin[drag.body];
    const int phi = dynamics::AbsoluteTree::angle_index(drag.body);

    Vec2 along;
    const Vec2 normal = drag_normal(drag, p, along);
    const Vec2 air = pivot_velocity(path, p) - drag.wind_W;
    const DragLoad load = drag_load(drag, normal.dot(air), p.motion.V[phi], smoothing_);
    flow_gradients(path, phi, normal, along, air, p.motion.V, p, p.g_Y, p.g_V);

    // Virtual work: sigma's gradient by nu is s's by V, so its derivative by Y is the transpose of
    // d2s/dYdV.

    p.NN1.setZero();
    add_flow_YV(path, phi, normal, along, load.force, p, p.NN1);
    p.Res_Y -= p.NN1.transpose();
    p.Res_Y.noalias() -= (load.d(0, 0) * p.g_V) * p.g_Y.transpose();
    p.Res_Y.row(phi) -= load.d(1, 0) * p.g_Y.transpose();
    p.Res_V.noalias() -= (load.d(0, 0) * p.g_V) * p.g_V.transpose();
    p.Res_V.col(phi) -= load.d(0, 1) * p.g_V;
    p.Res_V.row(phi) -= load.d(1, 0) * p.g_V.transpose();
    p.Res_V(phi, phi) -= load.d(1, 1);
  }
}

void Equations::add_drag_hessian(EquationsPoint& p) const {
  for (const model::PlanarDrag& drag : model_.drags) {
    if (drag.kind == model::DragKind::none || drag.coefficient == 0.0) continue;
    const dynamics::Path& path = tree_.origin[drag.body];
    const int phi = dynamics::AbsoluteTree::angle_index(drag.body);
    Vec2 along;
    const Vec2 normal = drag_normal(drag, p, along);
    const Vec2 air = pivot_velocity(path, p) - drag.wind_W, slip = p.J.times(p.nu);
    const DragLoad load = drag_load(drag, normal.dot(air), p.motion.V[phi], smoothing_);
    const double sigma = normal.dot(slip), turn = p.nu[phi];
    // Weighted derivatives of force sigma + moment nu_phi by (s, omega).
    const double w_s = sigma * load.d(0, 0) + turn * load.d(1, 0);
    const Mat2 w = sigma * load.force_dd + turn * load.moment_dd;

    // sigma's; g_V is s's by V alike
    flow_gradients(path, phi, normal, along, slip, p.nu, p, p.g_Y, p.g_V);
    add_flow_YY(path, phi, normal, along, slip, p.nu, -load.force, p, p.YY);
    p.chi_scratch = p.g_Y;
    flow_gradients(path, phi, normal, along, air, p.motion.V, p, p.g_Y, p.g_V);
    add_flow_YY(path, phi, normal, along, air, p.motion.V, -w_s, p, p.YY);
    add_flow_YV(path, phi, normal, along, -w_s, p, p.YV);

    p.YY.noalias() -= (w(0, 0) * p.g_Y) * p.g_Y.transpose();
    p.YY.noalias() -= (load.d(0, 0) * p.g_Y) * p.chi_scratch.transpose();
    p.YY.noalias() -= (load.d(0, 0) * p.chi_scratch) * p.g_Y.transpose();
    p.YV.noalias() -= (w(0, 0) * p.g_Y) * p.g_V.transpose();
    p.YV.col(phi) -= w(0, 1) * p.g_Y;
    p.YV.noalias() -= (load.d(0, 0) * p.chi_scratch) * p.g_V.transpose();
    p.YV.col(phi) -= load.d(0, 1) * p.chi_scratch;
    p.VV.noalias() -= (w(0, 0) * p.g_V) * p.g_V.transpose();
    p.VV.col(phi) -= w(0, 1) * p.g_V;
    p.VV.row(phi) -= w(0, 1) * p.g_V.transpose();
    p.VV(phi, phi) -= w(1, 1);
  }
}

Vec2 Equations::drag_force(const EquationsPoint& p) const {
  Vec2 total = Vec2::Zero();
  dynamics::PointColumns J;
  for (const model::PlanarDrag& drag : model_.drags) {
    Vec2 along;
    const Vec2 normal = drag_normal(drag, p, along);
    dynamics::jacobian_columns(tree_.origin[drag.body], p.motion.pose, J);
    const Vec2 air = J.times(p.motion.V) - drag.wind_W;
    const double omega = p.motion.V[dynamics::AbsoluteTree::angle_index(drag.body)];
    total += drag_load(drag, normal.dot(air), omega, smoothing_).force * normal;
  }
  return total;
}

double Equations::drag_power(const EquationsPoint& p) const {
  double total = 0.0;
  dynamics::PointColumns J;
  for (const model::PlanarDrag& drag : model_.drags) {
    Vec2 along;
    const Vec2 normal = drag_normal(drag, p, along);
    dynamics::jacobian_columns(tree_.origin[drag.body], p.motion.pose, J);
    const Vec2 velocity = J.times(p.motion.V);
    const double omega = p.motion.V[dynamics::AbsoluteTree::angle_index(drag.body)];
    const DragLoad load = drag_load(drag, normal.dot(velocity - drag.wind_W), omega, smoothing_);
    total += load.force * normal.dot(velocity) + load.moment * omega;
  }
  return total;
}

double Equations::drag_moment(const EquationsPoint& p) const {
  double total = 0.0;
  dynamics::PointColumns J;
  for (const model::PlanarDrag& drag : model_.drags) {
    Vec2 along;
    const Vec2 normal = drag_normal(drag, p, along);
    const dynamics::Path& path = tree_.origin[drag.body];
    dynamics::jacobian_columns(path, p.motion.pose, J);
    const Vec2 at = dynamics::position(path, p.motion.pose),
               air = J.times(p.motion.V) - drag.wind_W;
    const double omega = p.motion.V[dynamics::AbsoluteTree::angle_index(drag.body)];
    const DragLoad load = drag_load(drag, normal.dot(air), omega, smoothing_);
    // About +y: z F_x - x F_z.
    total += load.moment + load.force * (at.y() * normal.x() - at.x() * normal.y());
  }
  return total;
}

}  // namespace jaculus::components
