// Drag in the equations of motion. With the pivot's Jacobian J, the normal e' = dR/dphi e and the
// tail's direction e = R direction,
//   s = e' . (J V - wind),   sigma = e' . J nu   (the same with the virtual motion nu),
// drag adds -(force(s, omega) sigma + moment(s, omega) nu_phi) to nu . r. Derivatives of s:
//   ds/dY = e' . D(V) - e . (J V - wind) at phi,      ds/dV = J^T e',
//   d2s/dY2 = T(e', V) with the mixed terms -e . D(V) at (., phi) and -e' . (J V - wind) at
//             (phi, phi),
//   d2s/dYdV = H(e') with -J^T e in row phi.

#include "components/point_terms.h"

namespace jaculus::components {

namespace {

template <class S>
Vec2Of<S> flow_normal(const model::PlanarDrag& drag, const EquationsPointOf<S>& p,
                      Vec2Of<S>& along) {
  const int phi = dynamics::AbsoluteTree::angle_index(drag.body);
  const S c = p.motion.pose.cosine[phi], s = p.motion.pose.sine[phi];
  const S ex = S(drag.direction.x()), ez = S(drag.direction.y());
  along = Vec2Of<S>(c * ex + s * ez, c * ez - s * ex);
  return {along.y(), -along.x()};
}

template <class S>
S product(const Vec2Of<S>& a, const S& x, const S& z) {
  return a.x() * x + a.y() * z;
}

/// Derivative of e' . (J X - wind) by Y, in columns; p.J holds the pivot's, p.Dnu is given D(X).
template <class S>
void flow_gradient(const dynamics::Path& path, const DragPointOf<S>& flow, const Vec2Of<S>& air,
                   const VectorOf<S>& X, EquationsPointOf<S>& p, std::vector<S>& by_Y) {
  p.Dnu.take_pattern(p.J);
  dynamics::add_D(path, p.motion.pose, X, 1.0, p.Dnu);
  for (int k = 0; k < p.J.count; ++k) by_Y[k] = product(flow.normal, p.Dnu.x[k], p.Dnu.z[k]);
  by_Y.back() = -product(flow.along, air.x(), air.y());
}

/// YY += scale * d2(e' . (J X - wind))/dY2; p.Dnu must hold D(X).
template <class S>
void add_flow_YY(const dynamics::Path& path, const DragPointOf<S>& flow, const Vec2Of<S>& air,
                 const VectorOf<S>& X, const S& scale, EquationsPointOf<S>& p) {
  const int phi = flow.index.back();
  const Vec2Of<S> weight = scale * flow.normal;
  dynamics::add_T(path, p.motion.pose, weight, X, p.YY);
  for (int k = 0; k < p.Dnu.count; ++k) {
    const S cross = scale * product(flow.along, p.Dnu.x[k], p.Dnu.z[k]);
    p.YY(p.Dnu.index[k], phi) -= cross;
    p.YY(phi, p.Dnu.index[k]) -= cross;
  }
  p.YY(phi, phi) -= scale * product(flow.normal, air.x(), air.y());
}

/// out -= the second derivatives of the force's part, -(f sigma + m nu_phi), that are products of
/// first ones.
template <class S>
void subtract_products(const DragPointOf<S>& flow, const S& w_ss, const S& w_so, const S& w_oo,
                       EquationsPointOf<S>& p) {
  const S by_s = flow.load.d(0, 0), by_omega = flow.load.d(0, 1);
  const std::vector<int>& at = flow.index;
  const int phi = at.back();

  for (std::size_t j = 0; j < at.size(); ++j) {
    const S& Y_j = flow.s_Y[j];
    const S &V_j = flow.s_V[j], &slip_j = flow.slip_Y[j];
    for (std::size_t i = 0; i < at.size(); ++i) {
      const S &Y_i = flow.s_Y[i], &V_i = flow.s_V[i], &slip_i = flow.slip_Y[i];
      p.YY(at[i], at[j]) -= w_ss * Y_i * Y_j + by_s * (Y_i * slip_j + slip_i * Y_j);
      p.YV(at[i], at[j]) -= (w_ss * Y_i + by_s * slip_i) * V_j;
      p.VV(at[i], at[j]) -= w_ss * V_i * V_j;
    }
    p.YV(at[j], phi) -= w_so * Y_j + by_omega * slip_j;
    p.VV(at[j], phi) -= w_so * V_j;
    p.VV(phi, at[j]) -= w_so * V_j;
  }
  p.VV(phi, phi) -= w_oo;
}

}  // namespace

template <class S>
void Equations::add_drag(EquationsPointOf<S>& p) const {
  for (DragPointOf<S>& flow : p.drags) {
    const model::PlanarDrag& drag = model_.drags[flow.drag];
    const int phi = flow.index.back();
    flow.normal = flow_normal(drag, p, flow.along);
    dynamics::jacobian_columns(tree_.origin[drag.body], p.motion.pose, p.J);
    flow.air = p.J.times(p.motion.V);
    flow.air.x() -= S(drag.wind_W.x());
    flow.air.y() -= S(drag.wind_W.y());
    const S s = product(flow.normal, flow.air.x(), flow.air.y());
    flow.load = drag_load(drag, s, p.motion.V[phi], smoothing_);

    const Vec2Of<S> force = flow.load.force * flow.normal;
    p.J.add_transposed(force, -1.0, p.r);
    p.r[phi] -= flow.load.moment;
  }
}

template <class S>
void Equations::add_drag_derivatives(EquationsPointOf<S>& p) const {
  for (DragPointOf<S>& flow : p.drags) {
    const dynamics::Path& path = tree_.origin[model_.drags[flow.drag].body];
    const std::vector<int>& at = flow.index;
    const int phi = at.back();
    const DragLoadOf<S>& load = flow.load;

    dynamics::jacobian_columns(path, p.motion.pose, p.J);
    flow_gradient(path, flow, flow.air, p.motion.V, p, flow.s_Y);
    for (int k = 0; k < p.J.count; ++k) flow.s_V[k] = product(flow.normal, p.J.x[k], p.J.z[k]);
    flow.s_V.back() = S(0.0);

    // Virtual work: sigma's gradient by nu is s's by V, so its derivative by Y is the transpose of
    // d2s/dYdV.
    const Vec2Of<S> against = -load.force * flow.normal;
    dynamics::add_H(path, p.motion.pose, against, p.Res_Y);
    for (int k = 0; k < p.J.count; ++k)
      p.Res_Y(at[k], phi) += load.force * product(flow.along, p.J.x[k], p.J.z[k]);

    for (std::size_t j = 0; j < at.size(); ++j) {
      for (std::size_t i = 0; i < at.size(); ++i) {
        const S by_i = load.d(0, 0) * flow.s_V[i];
        p.Res_Y(at[i], at[j]) -= by_i * flow.s_Y[j];
        p.Res_V(at[i], at[j]) -= by_i * flow.s_V[j];
      }
      p.Res_Y(phi, at[j]) -= load.d(1, 0) * flow.s_Y[j];
      p.Res_V(phi, at[j]) -= load.d(1, 0) * flow.s_V[j];
      p.Res_V(at[j], phi) -= load.d(0, 1) * flow.s_V[j];
    }
    p.Res_V(phi, phi) -= load.d(1, 1);
  }
}

template <class S>
void Equations::add_drag_hessian(EquationsPointOf<S>& p) const {
  for (DragPointOf<S>& flow : p.drags) {
    const dynamics::Path& path = tree_.origin[model_.drags[flow.drag].body];
    const int phi = flow.index.back();
    const DragLoadOf<S>& load = flow.load;

    dynamics::jacobian_columns(path, p.motion.pose, p.J);
    const Vec2Of<S> slip = p.J.times(p.nu);
    const S sigma = product(flow.normal, slip.x(), slip.y()), turn = p.nu[phi];
    // Weighted derivatives of force sigma + moment nu_phi by (s, omega).
    const S w_s = sigma * load.d(0, 0) + turn * load.d(1, 0);
    const auto second = [&](int i, int j) {
      return S(sigma * load.force_dd(i, j) + turn * load.moment_dd(i, j));
    };

    flow_gradient(path, flow, slip, p.nu, p, flow.slip_Y);
    add_flow_YY(path, flow, slip, p.nu, S(-load.force), p);
    flow_gradient(path, flow, flow.air, p.motion.V, p, flow.s_Y);
    add_flow_YY(path, flow, flow.air, p.motion.V, S(-w_s), p);

    const Vec2Of<S> against = -w_s * flow.normal;
    dynamics::add_H(path, p.motion.pose, against, p.YV);
    for (int k = 0; k < p.J.count; ++k)
      p.YV(phi, p.J.index[k]) += w_s * product(flow.along, p.J.x[k], p.J.z[k]);
    subtract_products(flow, second(0, 0), second(0, 1), second(1, 1), p);
  }
}

#define JACULUS_INSTANTIATE(S)                                                  \
  template void Equations::add_drag<S>(EquationsPointOf<S>&) const;             \
  template void Equations::add_drag_derivatives<S>(EquationsPointOf<S>&) const; \
  template void Equations::add_drag_hessian<S>(EquationsPointOf<S>&) const;

JACULUS_INSTANTIATE(double)
JACULUS_INSTANTIATE(Lanes)
#undef JACULUS_INSTANTIATE

Vec2 Equations::drag_force(const EquationsPoint& p) const {
  Vec2 total = Vec2::Zero();
  dynamics::PointColumns J;
  for (const model::PlanarDrag& drag : model_.drags) {
    Vec2 along;
    const Vec2 normal = flow_normal(drag, p, along);
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
    const Vec2 normal = flow_normal(drag, p, along);
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
    const Vec2 normal = flow_normal(drag, p, along);
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
