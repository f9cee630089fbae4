#pragma once
// Rigid-body dynamics of the planar robot in generalised coordinates, loops included, and functions of a point with exact derivatives.
//
// With the map V = G v, A = G a + gamma of loop_closure.h, bodies b of mass m_b and inertia I_b about their centres of mass, feet f:
//     M   = G^T [sum_b m_b J_b^T J_b + I_b e_b e_b^T] G + armature          mass matrix (n x n)
//     h   = G^T [sum_b m_b J_b^T (J_b gamma + V^T d2p_b V - g) + I_b gamma_b e_b]   bias: Coriolis, centrifugal, gravity (n)
//     M a + h = Q + J_f^T f                                                 Q: motors and drag (equations.h adds these two)
// Loop forces do no virtual work in G's columns and never appear.
//
// Functions of a point, for rows of an optimisation: phi(q, v) = w_p . p + w_v . dp/dt, p a weighted sum of path ends (one foot,
// the centre of mass, a difference of two points). Call set_configuration, set_rates and set_rate_sensitivity first, or
// Equations::evaluate and differentiate; then
//     add_point_gradient(tree, motion, point, w_p, w_v, gradient (2n), scratch)         adds d(phi)/d(q, v)
//     add_point_hessian (tree, motion, point, w_p, w_v, hessian (2n x 2n), scratch)     adds d2(phi)/d(q, v)2
// neither of which allocates. The dependent joints' curvature enters by multipliers that make
//     L = phi + chi_1 . (C V) + chi_0 . c     stationary in the dependent rates (chi_1) and values (chi_0):
//     C_d^T chi_1 = -P_d^T dphi/dV,   C_d^T chi_0 = -P_d^T (dphi/dY + d(chi_1 . C V)/dY),
//     L_YY = H(w_p) + T(w_v, V) + T_c(chi_1, V) + H_c(chi_0),   L_YV = H(w_v) + H_c(chi_1)
// of which d2(phi)/dq2 = G^T L_YY G + G^T L_YV X + X^T L_YV^T G and d2(phi)/dqdv = G^T L_YV G.

#include <vector>

#include "jaculus/dynamics/loop_closure.h"

namespace jaculus {

/// One path end of a weighted sum.
struct WeightedPath {
  double weight = 1.0;
  Path path;
};

/// A point of the robot as a weighted sum of path ends; weights that sum to zero make a relative position.
using PointSum = std::vector<WeightedPath>;

PointSum foot_point(const AbsoluteTree& tree, int foot);
PointSum centre_of_mass_point(const AbsoluteTree& tree);

/// Scratch of the point functions: sized once for a tree, then reused without allocation. No result is read from it.
struct PointScratch {
  explicit PointScratch(const AbsoluteTree& tree);

  Vector g_Y, g_V, chi_0, chi_1, dependent;
  Matrix YY, YV, YY_G, YV_G, YV_X;
  PointColumns J, D;
};

Vec2 point_position(const PointSum& point, const Motion& motion);  ///< world [m]
Vec2 point_velocity(const PointSum& point, const Motion& motion);  ///< world [m/s]; the rates must be set
/// Adds d(w_position . p + w_velocity . dp/dt)/d(q, v) to `gradient` (2n). See the top for what must be set.
void add_point_gradient(const AbsoluteTree& tree, const Motion& motion, const PointSum& point, const Vec2& w_position,
                        const Vec2& w_velocity, VectorRef gradient, PointScratch& scratch);
/// Adds the second derivatives of the same to `hessian` (2n x 2n, symmetric, both halves).
void add_point_hessian(const AbsoluteTree& tree, const Motion& motion, const PointSum& point, const Vec2& w_position,
                       const Vec2& w_velocity, MatrixRef hessian, PointScratch& scratch);

}  // namespace jaculus
