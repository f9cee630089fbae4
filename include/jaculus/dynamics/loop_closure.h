#pragma once
// Loops solved for their dependent joints, at the level of position, rate and acceleration.
//
// A loop is a dyad: the pin is the intersection of two circles about the roots of the two dependent
// links, on the branch that the model states, so d(q) is in closed form and needs no iteration.
// With c = p_A - p_B and C = dc/dY (2 rows a loop):
//     C_d = C P_d,  D = -C_d^-1 C P,  G = P + P_d D,  V = G v,
//     A = G a + gamma,  gamma = -P_d C_d^-1 (V^T d2c V),
//     X = dV/dq at fixed v = -P_d C_d^-1 dC(V)/dY G.

#include <Eigen/LU>

#include "jaculus/dynamics/kinematics.h"

namespace jaculus::dynamics {

/// Configuration and rates of the robot in absolute coordinates. Scratch: sized once by the
/// constructor, then reused. S: double, or Lanes for four configurations at once.
template <class S>
struct MotionOf {
  explicit MotionOf(const AbsoluteTree& tree);

  PoseOf<S> pose;
  VectorOf<S> d;      ///< nd dependent joint values [rad], in (-pi, pi]
  VectorOf<S> V;      ///< N absolute rates
  VectorOf<S> gamma;  ///< N absolute accelerations at zero generalised acceleration
  MatrixOf<S> C;      ///< loop Jacobian (2 rows a loop) x N
  MatrixOf<S> C_d;    ///< nd x nd
  MatrixOf<S> C_d_inverse;
  MatrixOf<S> D;  ///< nd x n
  MatrixOf<S> G;  ///< N x n; other elements than those of the tree's G_pattern are zero
  MatrixOf<S> X;  ///< N x n, see above, of X_pattern; filled by set_rate_sensitivity()
  MatrixOf<S> scratch_dn, scratch_dn2, scratch_dN;
  PointColumnsOf<S> columns;
};
using Motion = MotionOf<double>;

/// Sets pose, d, C, D and G at q (n). False where a loop cannot close, in any lane.
template <class S>
bool set_configuration(const AbsoluteTree& tree, VectorArg<S> q, MotionOf<S>& motion);
/// Sets V and gamma at v (n); the configuration must be set.
template <class S>
void set_rates(const AbsoluteTree& tree, VectorArg<S> v, MotionOf<S>& motion);
/// Sets X; the rates must be set.
template <class S>
void set_rate_sensitivity(const AbsoluteTree& tree, MotionOf<S>& motion);
/// d(V^T d2c V + C A)/dY and /dV of the loops: (2 rows a loop) x N each; `at_rest` leaves V out, as
/// an impact does.
template <class S>
void loop_acceleration_derivatives(const AbsoluteTree& tree, MotionOf<S>& motion,
                                   const VectorOf<S>& A, bool at_rest, MatrixOf<S>& dY,
                                   MatrixOf<S>& dV);

/// Absolute coordinates as joint values: all bodies' joints, the base's entry zero [rad or m].
Vector joint_positions(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& q,
                       const Motion& motion);
/// The joints' rates, all bodies [rad/s or m/s].
Vector joint_velocities(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& v,
                        const Motion& motion);

}  // namespace jaculus::dynamics
