#pragma once
// The plant's equations of motion at a state and at given contact modes:
//     M a + h = B tau + Q_drag + Q_friction + Q_hinges + Q_push + J^T lambda,    J a + gamma = 0 on closed rows,
// by Cholesky M = L L^T and Delassus' matrix of the rows that touch (contact_law.h). State y = (q, v, winding temperatures, soles'
// deflections), q with the hinges behind the model's coordinates.

#include <string>
#include <vector>

#include "jaculus/simulation/simulate.h"
#include "simulation/commander.h"
#include "simulation/contact_law.h"
#include "simulation/drive.h"
#include "simulation/mechanism.h"

namespace jaculus::detail {

/// A contact that pushes only: a foot, another point, or a joint's stop.
struct Unilateral {
  std::string name;
  int body = 0;
  Vec2 position = Vec2::Zero();
  double radius = 0.0;  ///< of a foot [m]
  int count = 1;        ///< left and right
  double mu = -1.0;     ///< negative: a stop
  double side = 0.0;    ///< of a stop: +1 keeps above `bound`, -1 below
  double bound = 0.0;   ///< [rad or m]
  double restitution = 0.0;
  int foot = -1;  ///< index of the model's feet
  [[nodiscard]] bool stop() const { return side != 0.0; }
};

/// A unilateral contact at a state.
struct ContactState {
  double gap, normal_rate, tangential_rate, normal_bias, tangential_bias;
  Row normal, tangential;
};

class PlantEquations {
 public:
  PlantEquations(const Plant& plant, const Controller& controller);

  [[nodiscard]] const std::string& motor_name(size_t m) const { return plant_.model.motors[m].joint; }
  [[nodiscard]] int n() const { return mechanism.n; }
  [[nodiscard]] int states() const { return bristles() + (compliant_ ? static_cast<int>(points_) : 0); }
  /// Index of the first bristle, one a foot or point, in the state.
  [[nodiscard]] int bristles() const { return 2 * mechanism.n + (warm_ ? static_cast<int>(drive.motors.size()) : 0); }
  /// Whether a contact is with compliant ground: a force, no constraint.
  [[nodiscard]] bool compliant(size_t i) const { return compliant_ && i < points_; }

  /// Takes what changes by a jump at t: commands, pushes. After set_state.
  void update(double t, const double* y);
  [[nodiscard]] double next_change(double t) const;
  /// "; front_extension is at 3.1, beyond its range 0.4 to 2.74" for the coordinate that is furthest outside, or nothing.
  [[nodiscard]] std::string beyond_range(const double* y) const;
  /// Finds the torques that hold the pose and commands them until the controller's first command. False where singular.
  bool hold(double t, const double* y);
  /// Lets hinges hang and a compliant floor carry: turns y, which is at rest, into the static equilibrium of what neither a motor nor a
  /// rigid contact holds. After update(); false where there is none.
  bool rest(double t, double* y);
  /// Positions and rates alone: frames, contacts' gaps and rates.
  bool set_state(const double* y);
  /// Everything up to the free acceleration (no contact): after set_state and set_mass at the same y.
  void set_forces(double t, const double* y);
  /// Delassus' matrix of the contacts in `touching`; after set_mass.
  void fill_rows(const std::vector<int>& touching);
  /// The rest of their system; after fill_rows, and set_forces or (`impact`: b from the rates v) nothing else.
  void fill_system(const std::vector<int>& touching, bool impact, const double* v);
  /// The whole right-hand side at `modes`. False: no loop closes, or M or the contacts are singular. `stands`: the last evaluation
  /// was at these y and modes, and commands alone have changed since.
  bool evaluate(double t, const double* y, double* dydt, bool stands = false);
  /// M at the state, factorised; after set_state.
  bool set_mass();
  /// x += M^-1 J^T lambda of the system's contacts.
  void add_response(const std::vector<int>& touching, const double* lambda, double* x) const;

  Mechanism mechanism;
  Drive drive;
  Commander commander;
  std::vector<Unilateral> unilaterals;
  std::vector<ContactState> contacts;
  std::vector<Touch> modes;
  std::vector<double> lambda;  ///< 2 a unilateral: tangential, normal
  ContactSystem system;
  double bus = 0.0;
  long evaluations = 0;
  std::vector<double> motor_position, motor_velocity;
  double force_scale = 1.0;
  std::vector<double> bristle_rate;  ///< of the soles on compliant ground [m/s]
  std::vector<Touch> sole;           ///< whether they stick or slip, where in contact

 private:
  void add_unilaterals();
  void read_motors(const double* y);
  void add_elements();
  void add_drag();
  void add_ground(const double* y);
  void add_joint_friction();
  void add_hinges(const double* y);
  [[nodiscard]] std::vector<int> loose_coordinates() const;
  /// Q - h of some coordinates; false where no loop closes.
  bool unbalanced(double t, const double* y, const std::vector<int>& rows, Vector& out);
  void set_contact(size_t i, const double* y);
  void forward(double* x) const;   ///< x = L^-1 x
  void backward(double* x) const;  ///< x = L^-T x

  struct Friction {
    const JointFriction* data;
    int body, motor, count;
  };
  struct Spring {
    double stiffness, damping_ratio, half_play, smoothing;
    double damping = -1.0;  ///< set at the first state, whose inertia it goes by
  };
  const Plant& plant_;
  CommandQuantity quantity_;
  bool holding_ = false, compliant_ = false;
  double mass_of_foot_ = 0.0;  ///< the robot's, over its feet left and right [kg]
  size_t points_ = 0;          ///< feet and ground points, which come first among the unilaterals
  std::vector<Command> hold_;
  std::vector<Friction> friction_;
  std::vector<Spring> springs_;
  double heat_ = 0.0;
  bool warm_ = false;  ///< windings' temperatures are states
  std::vector<bool> pushing_;
  std::vector<int> touching_;
  std::vector<Touch> touching_modes_;
  template <int kRows>
  void solve_rows();
  double L_[kMaxSize * kMaxSize], h_[kMaxSize], force_[kMaxSize], free_[kMaxSize];
  double solved_[kMaxSize * kStride];  ///< L^-1 J^T of the system's rows, row by row: n x kStride
  double inverse_diagonal_[kMaxSize];
};

}  // namespace jaculus::detail
