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
// u (n_u) is one motor's torque at the joint beside what it gives against dry friction (motor.h); B
// counts left and right. Viscous friction stands beside it: u - b omega, omega = W v the rates of
// their joints.
//
// First derivatives differentiate the whole system, loop forces and dependent joints included;
// second derivatives use the adjoint
//     K^T (nu, kappa) = mu   =>
//       d2(mu . (a, f)) = -d2(nu . r + kappa . pdd_f + kappa_l . cdd + chi_1 . cd + chi_0 . c),
// where kappa_l, chi_1, chi_0 make the sum stationary in the dependent joints' accelerations, rates
// and values.
//
// The system is solved by saddle.h. In coordinates, with Y = P q + P_d d and the maps G, X of
// loop_closure.h: what is by (Y, V) is chained to (q, v), and what moves by the dependent joints
// goes by loop_w = C_d^-1 d(cdd)/d(q, v), for dA = G da - P_d loop_w.
//
// Plastic impact (feet stop dead, joints stay closed, motors, gravity and drag give no impulse) is
// the same system with the jump of the rates in place of a and impulses in place of forces: M dv -
// J^T p = 0, J (v + dv) = 0.
//
// S is the scalar: double for one point, Lanes for four at once (core/lanes.h).

#include <vector>

#include "jaculus/components/saddle.h"
#include "jaculus/components/tail_drag.h"
#include "jaculus/dynamics/loop_closure.h"

namespace jaculus::components {

/// Scratch and results of one evaluation; sized once for a contact set, reused without allocation.
template <class S>
struct EquationsPointOf;
using EquationsPoint = EquationsPointOf<double>;

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
  /// are singular, in any lane.
  template <class S>
  bool evaluate(VectorArg<S> q, VectorArg<S> v, VectorArg<S> u, EquationsPointOf<S>& p) const;
  /// The same for a plastic impact at rates v before it: p.a is the jump dv of the rates, p.force
  /// the impulses [N s].
  template <class S>
  bool evaluate_impact(VectorArg<S> q, VectorArg<S> v, EquationsPointOf<S>& p) const;
  /// Fills p.Z = d(a, force)/d(q, v, u), (n + 2 feet) x (2 n + n_u). After evaluate().
  template <class S>
  void differentiate(EquationsPointOf<S>& p) const;
  /// Adds d2(mu . (a, force))/d(q, v, u)^2 to H, (2 n + n_u)^2. After differentiate().
  template <class S>
  void add_hessian(VectorArg<S> mu, EquationsPointOf<S>& p, MatrixOf<S>& H) const;

  /// Force of the drag on the robot, world frame [N], and its power [W] (negative: taken from the
  /// robot). After evaluate().
  [[nodiscard]] Vec2 drag_force(const EquationsPoint& p) const;
  [[nodiscard]] double drag_power(const EquationsPoint& p) const;
  /// Moment of the drag about the world origin, turning about +y [N m]. After evaluate().
  [[nodiscard]] double drag_moment(const EquationsPoint& p) const;

 private:
  template <class S>
  bool solve_system(EquationsPointOf<S>& p) const;
  template <class S>
  void add_friction(EquationsPointOf<S>& p) const;
  template <class S>
  void add_friction_derivatives(EquationsPointOf<S>& p) const;
  template <class S>
  void add_drag(EquationsPointOf<S>& p) const;
  template <class S>
  void add_drag_derivatives(EquationsPointOf<S>& p) const;
  template <class S>
  void add_drag_hessian(EquationsPointOf<S>& p) const;

  model::PlanarModel model_;
  dynamics::AbsoluteTree tree_;
  double smoothing_;
  std::vector<int> rubbing_;  ///< motors with viscous friction
};

/// How a tail meets the air, in the words of equations_drag.cpp. Rows and columns of its
/// derivatives are those of the pivot's J and phi, the last one.
template <class S>
struct DragPointOf {
  int drag = 0;                  ///< index among the model's drags
  std::vector<int> index;        ///< absolute, of a column
  Vec2Of<S> normal, along, air;  ///< e', e, J V - wind [m/s]
  DragLoadOf<S> load;
  std::vector<S> s_Y, s_V, slip_Y;  ///< ds/dY, ds/dV, d(e' . J nu)/dY by columns
};

template <class S>
struct EquationsPointOf {
  EquationsPointOf(const Equations& equations, const std::vector<int>& feet_in_contact);

  std::vector<int> feet;  ///< indices of the feet in contact
  dynamics::MotionOf<S> motion;
  VectorOf<S> q, v;
  VectorOf<S> a;        ///< n
  VectorOf<S> force;    ///< 2 a foot in contact: x, z [N]
  MatrixOf<S> Z;        ///< see differentiate()
  MatrixOf<S> mass;     ///< n x n, of the coordinates
  bool impact = false;  ///< whether the last evaluation was of an impact
  // Scratch. In absolute coordinates:
  VectorOf<S> A, A_feet, r, nu, g_Y, g_V, loop_force, kappa_l, chi_0, chi_1;
  MatrixOf<S> M, MG, J_f, J_G;                   ///< mass, M G, the feet's Jacobian, J_f G
  MatrixOf<S> Res_Y, Res_V, F_Y, F_V, L_Y, L_V;  ///< of r, the feet's and the loops' pdd
  MatrixOf<S> chain;                             ///< d(r, A fixed)/d(q, v), N x 2n
  MatrixOf<S> YY, YV, VV, YA;                    ///< second derivatives of the adjoint sum
  MatrixOf<S> D_feet, D_loops;                   ///< D(nu)^T of feet and loops, N x rows
  // By way of the dependent joints:
  MatrixOf<S> d_loops, loop_w;            ///< d(cdd)/d(q, v), C_d^-1 of it: nd x 2n
  MatrixOf<S> PMG, PMG_t, PMP, JP, JP_t;  ///< P_d^T M G, P_d^T M P_d, J_f P_d
  MatrixOf<S> balance;                    ///< of the dependent joints, nd x 2n
  // In coordinates:
  VectorOf<S> adjoint;
  MatrixOf<S> GY, GV, XV, GD, GA, left, qq, qv, vv, nw, C_d_inverse_t, GAP;
  SaddleOf<S> saddle;
  dynamics::PointColumnsOf<S> J, PY, PV, Dnu;
  std::vector<DragPointOf<S>> drags;  ///< of the tails that drag
};

}  // namespace jaculus::components
