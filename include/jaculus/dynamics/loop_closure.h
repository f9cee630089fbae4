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
/// constructor, then reused.
struct Motion {
  explicit Motion(const AbsoluteTree& tree);

  Pose pose;
  Vector d;      ///< nd dependent joint values [rad], in (-pi, pi]
  Vector V;      ///< N absolute rates
  Vector gamma;  ///< N absolute accelerations at zero generalised acceleration
  Matrix C;      ///< loop Jacobian (2 rows a loop) x N
  Matrix C_d;    ///< nd x nd
  Matrix C_d_inverse;
  Matrix D;   ///< nd x n
  Matrix G;   ///< N x n
  Matrix Gt;  ///< n x N, its transpose: products go down columns
  Matrix X;   ///< N x n, see above; filled by set_rate_sensitivity()
  Matrix Xt;  ///< n x N
  Matrix scratch_dn, scratch_dn2, scratch_dN;
  PointColumns columns;
};

/// Sets pose, d, C, D and G at q (n). False where a loop cannot close.
bool set_configuration(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& q, Motion& motion);
/// Sets V and gamma at v (n); the configuration must be set.
void set_rates(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& v, Motion& motion);
/// Sets X; the rates must be set.
void set_rate_sensitivity(const AbsoluteTree& tree, Motion& motion);
/// d(V^T d2c V + C A)/dY and /dV of the loops: (2 rows a loop) x N each; `at_rest` leaves V out, as
/// an impact does.
void loop_acceleration_derivatives(const AbsoluteTree& tree, Motion& motion, const Vector& A,
                                   bool at_rest, Matrix& dY, Matrix& dV);

/// Absolute coordinates as joint values: all bodies' joints, the base's entry zero [rad or m].
Vector joint_positions(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& q,
                       const Motion& motion);
/// The joints' rates, all bodies [rad/s or m/s].
Vector joint_velocities(const AbsoluteTree& tree, const Eigen::Ref<const Vector>& v,
                        const Motion& motion);

}  // namespace jaculus::dynamics
