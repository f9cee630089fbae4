#pragma once
// Rigid-body dynamics of the planar robot in generalised coordinates, loops included, and functions
// of a point with exact derivatives.
//
// With the map V = G v, A = G a + gamma of loop_closure.h, bodies b of mass m_b and inertia I_b
// about their centres of mass, feet f:
//     M   = G^T [sum_b m_b J_b^T J_b + I_b e_b e_b^T] G + armature          mass matrix (n x n)
//     h   = G^T [sum_b m_b J_b^T (J_b gamma + V^T d2p_b V - g) + I_b gamma_b e_b]
//       bias: Coriolis, centrifugal, gravity (n)
//     M a + h = Q + J_f^T f                         Q: motors and drag (equations.h adds these two)
// Loop forces do no virtual work in G's columns and never appear.
//
// Functions of a point, for rows of an optimisation: phi(q, v) = w_p . p + w_v . dp/dt, p a
// weighted sum of path ends (one foot, the centre of mass, a difference of two points). Call
// set_configuration, set_rates and set_rate_sensitivity first, or Equations::evaluate and
// differentiate; then
//     add_point_gradient(tree, motion, point, w_p, w_v, gradient (2n), scratch)
//       adds d(phi)/d(q, v)
//     add_point_hessian (tree, motion, point, w_p, w_v, hessian (2n x 2n), scratch)
//       adds d2(phi)/d(q, v)2
// neither of which allocates. The dependent joints' curvature enters by multipliers that make
//     L = phi + chi_1 . (C V) + chi_0 . c
//       stationary in the dependent rates (chi_1) and values (chi_0):
//     C_d^T chi_1 = -P_d^T dphi/dV,   C_d^T chi_0 = -P_d^T (dphi/dY + d(chi_1 . C V)/dY),
//     L_YY = H(w_p) + T(w_v, V) + T_c(chi_1, V) + H_c(chi_0),   L_YV = H(w_v) + H_c(chi_1)
// of which d2(phi)/dq2 = G^T L_YY G + G^T L_YV X + X^T L_YV^T G and d2(phi)/dqdv = G^T L_YV G.

#include <vector>

#include "jaculus/dynamics/loop_closure.h"

namespace jaculus::dynamics {

/// One path end of a weighted sum.
struct WeightedPath {
  double weight = 1.0;
  Path path;
};

/// A point of the robot as a weighted sum of path ends; weights that sum to zero make a relative
/// position.
using PointSum = std::vector<WeightedPath>;

PointSum foot_point(const AbsoluteTree& tree, int foot);
PointSum centre_of_mass_point(const AbsoluteTree& tree);

/// Scratch of the point functions: sized once for a tree, then reused without allocation. No result
/// is read from it.
struct PointScratch {
  explicit PointScratch(const AbsoluteTree& tree);

  Vector g_Y, g_V, chi_0, chi_1, dependent;
  Matrix YY, YV, YY_G, YV_G, YV_X;
  PointColumns J, D;
};

Vec2 point_position(const PointSum& point, const Motion& motion);  ///< world [m]
/// world [m/s]; the rates must be set
Vec2 point_velocity(const PointSum& point, const Motion& motion);
/// Adds d(w_position . p + w_velocity . dp/dt)/d(q, v) to `gradient` (2n). See the top for what
/// must be set.
void add_point_gradient(const AbsoluteTree& tree, const Motion& motion, const PointSum& point,
                        const Vec2& w_position, const Vec2& w_velocity, VectorRef gradient,
                        PointScratch& scratch);
/// Adds the second derivatives of the same to `hessian` (2n x 2n, symmetric, both halves).
void add_point_hessian(const AbsoluteTree& tree, const Motion& motion, const PointSum& point,
                       const Vec2& w_position, const Vec2& w_velocity, MatrixRef hessian,
                       PointScratch& scratch);

// Dynamics. All take a motion whose configuration is set (and whose rates are, where marked
// "rates") and return values.

/// Adds sum_b m_b J_b^T J_b + I_b e_b e_b^T to `mass` (N x N) and sum_b m_b J_b^T (J_b A + V^T
/// d2p_b V - g) + I_b A_b e_b to `residual` (N): the bodies' share of the equations of motion in
/// absolute coordinates. No allocation. Rates.
template <class S>
void add_bodies(const AbsoluteTree& tree, const MotionOf<S>& motion, const VectorOf<S>& A,
                MatrixOf<S>& mass, VectorOf<S>& residual, PointColumnsOf<S>& scratch);

/// M (n x n), symmetric positive definite, reflected rotor inertia included [kg, kg m, kg m^2].
Matrix mass_matrix(const AbsoluteTree& tree, const Motion& motion);
/// h (n): the generalised force that keeps the generalised acceleration zero [N, N m]. Rates.
Vector bias(const AbsoluteTree& tree, const Motion& motion);
/// d(foot positions)/dq, (2 feet) x n, rows x and z of each foot in the order given.
Matrix foot_jacobian(const AbsoluteTree& tree, const Motion& motion, const std::vector<int>& feet);

Vec2 foot_position(const AbsoluteTree& tree, const Motion& motion, int foot);  ///< world [m]
/// world [m/s]. Rates.
Vec2 foot_velocity(const AbsoluteTree& tree, const Motion& motion, int foot);
/// World acceleration of a point at generalised acceleration a (n) [m/s^2]. Rates.
Vec2 point_acceleration(const PointSum& point, const Motion& motion, const Vector& a);

/// Q = M a + h - J_f^T f (n): the generalised force of motors and drag that goes with acceleration
/// a (n) and foot forces f (2 a foot: x, z; on the robot, left and right summed [N]). Rates.
Vector inverse_dynamics(const AbsoluteTree& tree, const Motion& motion, const Vector& a,
                        const std::vector<int>& feet, const Vector& force);

/// Outcome of forward_dynamics and plastic_impact; `ok` is false, and the rest empty, where M and
/// the feet's Jacobian make a singular system (feet that hold each other, a leg stretched out).
struct ContactSolution {
  bool ok = false;
  Vector motion;  ///< n: generalised acceleration, or rate after the impact
  Vector force;   ///< 2 a foot: x, z [N], or impulse [N s], on the robot
};

/// Solves M a + h = Q + J_f^T f with the acceleration of `feet` zero (held both ways: a pull is for
/// the caller to judge). Rates.
ContactSolution forward_dynamics(const AbsoluteTree& tree, const Motion& motion,
                                 const Vector& generalised_force, const std::vector<int>& feet);
/// Solves M (v_plus - v) = J_f^T impulse, J_f v_plus = 0: `feet` hit the floor at once and stay. v
/// is the rate before (n).
ContactSolution plastic_impact(const AbsoluteTree& tree, const Motion& motion, const Vector& v,
                               const std::vector<int>& feet);

Vec2 centre_of_mass(const AbsoluteTree& tree, const Motion& motion);  ///< world [m]
/// world [m/s]. Rates.
Vec2 centre_of_mass_velocity(const AbsoluteTree& tree, const Motion& motion);
Vec2 linear_momentum(const AbsoluteTree& tree, const Motion& motion);  ///< world [kg m/s]. Rates.
/// sum_b m_b (r_z v_x - r_x v_z) + I_b dphi_b/dt with r from `about`, a world point at rest; turns
/// about +y [kg m^2/s]. Rotors whose inertia is `armature` carry none: in that model they turn with
/// nothing but their joint. Rates.
double angular_momentum(const AbsoluteTree& tree, const Motion& motion, const Vec2& about);
/// The same about the moving centre of mass. Rates.
double angular_momentum(const AbsoluteTree& tree, const Motion& motion);
/// 1/2 v^T M v [J], rotors included, summed body by body. v (n) is what set_rates was given. Rates.
double kinetic_energy(const AbsoluteTree& tree, const Motion& motion, const Vector& v);
/// sum_b m_b g z_b [J], zero at world z = 0.
double potential_energy(const AbsoluteTree& tree, const Motion& motion);

}  // namespace jaculus::dynamics
