#pragma once
// The physics: equations of motion of a planar robot with feet in stance, motors and tail drag,
// with exact first and second derivatives. Everything that plans or simulates calls these.
//
// Unknown are the generalised acceleration a (n), and the forces on the feet f (2 a foot); loop
// forces l are eliminated. In absolute coordinates (kinematics.h), with A = G a + gamma, the
// residual of all bodies is
//     r = sum_b [m J^T (pdd - g) + I alpha] - J_f^T f - C^T l - Q_drag,
// and the system, G^T C^T = 0 having removed l, is
//     [ M  -J^T ] [a]   [ B u - G^T r(A = gamma, f = l = 0) ]        M = G^T M_abs G + armature,
//     [ J    0  ] [f] = [ -(J_f gamma + V^T d2p V)          ]        J = J_f G.
// u (n_u) is one motor's torque at the joint; B counts left and right. Friction of the motors
// (motor.h) stands beside it: u + tau_f(omega), omega = W v the rates of their joints.
//
// First derivatives differentiate the whole system, loop forces and dependent joints included;
// second derivatives use the adjoint
//     K^T (nu, kappa) = mu   =>
//       d2(mu . (a, f)) = -d2(nu . r + kappa . pdd_f + kappa_l . cdd + chi_1 . cd + chi_0 . c),
// where kappa_l, chi_1, chi_0 make the sum stationary in the dependent joints' accelerations, rates
// and values.
//
// Plastic impact (feet stop dead, joints stay closed, motors, gravity and drag give no impulse) is
// the same system with the jump of the rates in place of a and impulses in place of forces: M dv -
// J^T p = 0, J (v + dv) = 0.

#include <Eigen/LU>
#include <vector>

#include "jaculus/components/tail_drag.h"
#include "jaculus/dynamics/loop_closure.h"

namespace jaculus::components {

/// Scratch and results of one evaluation; sized once for a contact set, reused without allocation.
struct EquationsPoint;

/// The equations of one robot. Immutable.
class Equations {
 public:
  /// `smoothing` [m/s]: |u| in the drag law is sqrt(u^2 + smoothing^2) (tail_drag.h states the
  /// error).
  explicit Equations(const model::PlanarModel& model, double smoothing = 0.02);

  [[nodiscard]] const dynamics::AbsoluteTree& tree() const { return tree_; }
  [[nodiscard]] const model::PlanarModel& model() const { return model_; }
  [[nodiscard]] int size() const { return tree_.n; }
  [[nodiscard]] int inputs() const { return count_of(model_.motors); }

  /// Solves for p.a (n) and p.force (2 a foot in contact: x, z [N]). False where loops or stance
  /// are singular.
  bool evaluate(const Eigen::Ref<const Vector>& q, const Eigen::Ref<const Vector>& v,
                const Eigen::Ref<const Vector>& u, EquationsPoint& p) const;
  /// The same for a plastic impact at rates v before it: p.a is the jump dv of the rates, p.force
  /// the impulses [N s].
  bool evaluate_impact(const Eigen::Ref<const Vector>& q, const Eigen::Ref<const Vector>& v,
                       EquationsPoint& p) const;
  /// Fills p.Z = d(a, force)/d(q, v, u), (n + 2 feet) x (2 n + n_u). After evaluate().
  void differentiate(EquationsPoint& p) const;
  /// Adds d2(mu . (a, force))/d(q, v, u)^2 to H, (2 n + n_u)^2. After differentiate().
  void add_hessian(const Eigen::Ref<const Vector>& mu, EquationsPoint& p, Matrix& H) const;

  /// Force of the drag on the robot, world frame [N], and its power [W] (negative: taken from the
  /// robot). After evaluate().
  [[nodiscard]] Vec2 drag_force(const EquationsPoint& p) const;
  [[nodiscard]] double drag_power(const EquationsPoint& p) const;
  /// Moment of the drag about the world origin, turning about +y [N m]. After evaluate().
  [[nodiscard]] double drag_moment(const EquationsPoint& p) const;

 private:
  bool solve_system(EquationsPoint& p) const;
  void add_friction(EquationsPoint& p) const;
  void add_friction_derivatives(EquationsPoint& p) const;
  void add_friction_hessian(const EquationsPoint& p, Matrix& H) const;
  void add_drag(EquationsPoint& p) const;
  void add_drag_derivatives(EquationsPoint& p) const;
  void add_drag_hessian(EquationsPoint& p) const;
  [[nodiscard]] Vec2 drag_normal(const model::PlanarDrag& drag, const EquationsPoint& p,
                                 Vec2& along) const;

  model::PlanarModel model_;
  dynamics::AbsoluteTree tree_;
  double smoothing_;
  std::vector<int> rubbing_;  ///< motors with friction
};

struct EquationsPoint {
  EquationsPoint(const Equations& equations, const std::vector<int>& feet_in_contact);

  std::vector<int> feet;  ///< indices of the feet in contact
  dynamics::Motion motion;
  Vector q, v;
  Vector a;             ///< n
  Vector force;         ///< 2 a foot in contact: x, z [N]
  Matrix Z;             ///< see differentiate()
  bool impact = false;  ///< whether the last evaluation was of an impact
  // Scratch.
  Vector A, r, loop_force, A_feet;
  Matrix M, J_f, Res_Y, Res_V, F_Y, F_V, L_Y, L_V;
  Matrix K, rhs, Gamma, dA, d_loop_force;
  Vector rhs0, nu, kappa_l, chi_0, chi_1, g_Y, g_V, chi_scratch, adjoint;
  Matrix YY, YV, VV, YA, S_Y, NN1, NN2, MG, Nn, Nn2, Nw, nw, qq, qv;
  Matrix MP_d, P_dt, J_ft, loop_w;  ///< M P_d, P_d^T, J_f^T, C_d^-1 d(loop acceleration)
  Eigen::PartialPivLU<Matrix> lu;
  dynamics::PointColumns J, PY, PV, Dnu;
};

}  // namespace jaculus::components
