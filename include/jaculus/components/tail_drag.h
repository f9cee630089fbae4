#pragma once
// Quasi-steady aerodynamic drag of a slender tail, as a force and a moment about its pivot.
//
// The tail is a strip of width w along `direction` of its body, dragging from l = L0 to l = L. Let
// n(phi) = dR/dphi direction be the way its points move as phi grows (direction (0,1): n = (cos
// phi, -sin phi)), s = n . (v_pivot - wind) and omega = dphi/dt. The point at distance l meets the
// air at u = s + omega l, and feels along n, a unit of length,
//   -1/2 rho C_D w u |u|                                                   (equation 1, signed)
// so that
//   force  =  -k  Int_{L0}^{L}   u|u| dl,     k = 1/2 rho C_D w     (force on the tail = force * n)
//   moment =  -k  Int_{L0}^{L} l u|u| dl                        (equation 8; positive turns phi up)
// The flow reverses at l = -s/omega; where that lies on the strip the integral is split there.
//   point:     u = s + omega d, force = -1/2 rho C_D A u|u|, moment = d force
//     (d: point_distance, A: point_area)
//   rotation:  moment = -1/8 rho C_D w (L^4 - L0^4) omega|omega|, no force     (equation 2)
// Source: Norby et al. 2021, equations 1, 2 and 8.
//
// Smoothing. u|u| has a jump in its second derivative at rest, so a second-order solver gets u
// sqrt(u^2 + eps^2), which is analytic. As | u sqrt(u^2+eps^2) - u|u| | <= eps^2/2, the errors are
// at most
//   distributed:  |d force| <= k eps^2 (L - L0)/2,     |d moment| <= k eps^2 (L^2 - L0^2)/4
//   point:        |d force| <= k eps^2/2,              |d moment| <= d k eps^2/2
//   rotation:     (eps/L stands for eps)               |d moment| <= k (L^4 - L0^4) eps^2/(8 L^2)
// and they vanish with u. With eps = 0.05 m/s on the tail of Table I (k = 0.22) the moment errs by
// less than 9e-5 N m of some 3 N m. The integrals of the smoothed law are elementary (asinh); where
// the speed varies little along the strip those forms cancel and a 15-point Gauss-Legendre rule,
// accurate there to 1e-13 relative, takes over.
//
// Limits of validity: only the normal component of the flow, no lift, no added mass, constant C_D,
// still or uniform wind.

#include "jaculus/core/lanes.h"
#include "jaculus/model/planar.h"

namespace jaculus::components {

/// Drag on one tail with exact first and second derivatives (of the smoothed law, where smoothed).
template <class S>
struct DragLoadOf {
  using Square = Eigen::Matrix<S, 2, 2>;

  S force = S(0.0);                             ///< along n(phi), at the pivot [N]
  S moment = S(0.0);                            ///< about the pivot, positive with +phi [N m]
  Square d = Square::Constant(S(0.0));          ///< rows force, moment; columns s, omega
  Square force_dd = Square::Constant(S(0.0));   ///< second derivatives of the force by (s, omega)
  Square moment_dd = Square::Constant(S(0.0));  ///< of the moment
};
using DragLoad = DragLoadOf<double>;

/// n(phi): unit vector in the world along which the tail's points move as its absolute angle phi
/// [rad] grows.
Vec2 drag_normal(const model::PlanarDrag& drag, double phi);

/// The load at s [m/s], omega [rad/s]. `smoothing` is eps >= 0 [m/s]; 0 gives the exact signed law
/// (equation 8 in closed form), whose second derivatives are those of either side, and zero where
/// the whole tail is at rest.
DragLoad drag_load(const model::PlanarDrag& drag, double s, double omega, double smoothing);
DragLoadOf<Lanes> drag_load(const model::PlanarDrag& drag, const Lanes& s, const Lanes& omega,
                            double smoothing);

/// The load alone, as a plant needs it.
struct DragForce {
  double force = 0.0;   ///< along n(phi), at the pivot [N]
  double moment = 0.0;  ///< about the pivot, positive with +phi [N m]
};
DragForce drag_force(const model::PlanarDrag& drag, double s, double omega, double smoothing);

/// b of equation 2's moment = -b omega|omega|: 1/8 rho C_D w (L^4 - L0^4) [N m s^2].
double rotation_drag_factor(double density, double coefficient, double width, double start,
                            double end);

}  // namespace jaculus::components
