#pragma once
// The plant's equations of motion at a state and at given contact modes:
//     M a + h = B tau + Q_passive + Q_push + J^T lambda,   J a + gamma = 0 on closed rows,
// by Cholesky M = L L^T and Delassus' matrix of the rows that touch (contact_law.h).
//
// State y = (q, v, windings' temperatures, soles' deflections, states of laws), q with the hinges
// behind the model's coordinates. What follows from what is in the types: contacts() of a state,
// then its inertia(), then rows() of contacts; evaluate() is the whole right-hand side. Each works
// out for itself what it needs, and what stands at the same (q, v) already is taken as it is: no
// call's result depends on the calls before it.

#include <vector>

#include "simulation/contact/compliant_ground.h"
#include "simulation/contact/contact_rows.h"
#include "simulation/control/inputs.h"
#include "simulation/plant/laws.h"
#include "simulation/plant/passive_forces.h"

namespace jaculus::simulation::detail {

using State = std::vector<double>;

/// All that the equations say at a state. Valid until they are asked anything else.
struct Evaluation {
  std::vector<ContactState> contacts;  ///< one a unilateral
  std::vector<double> lambda;          ///< 2 a unilateral: tangential, normal [N or N m]
  std::vector<SoleState> soles;        ///< one a point, on compliant ground
  double bus = 0.0;                    ///< voltage [V]
};

/// Motors and bus at a sample.
struct DriveSample {
  std::vector<MotorState> motors;
  double bus = 0.0;  ///< voltage [V]
};

class PlantEquations {
 public:
  /// InputError where plant and controller don't fit. Both must outlive it.
  PlantEquations(const Plant& plant, const Controller& controller);
  PlantEquations(const PlantEquations&) = delete;  // what stands points into it
  PlantEquations& operator=(const PlantEquations&) = delete;

  // What it is of.
  [[nodiscard]] const Plant& plant() const { return plant_; }
  [[nodiscard]] const std::vector<Unilateral>& unilaterals() const { return unilaterals_; }
  [[nodiscard]] const std::vector<Hinge>& hinges() const { return mechanism_.hinges; }
  /// Coordinates, hinges included; those of the model alone come first.
  [[nodiscard]] int size() const { return mechanism_.n; }
  [[nodiscard]] int model_size() const { return mechanism_.n_model; }
  /// Indices in the state of the first winding, of the first sole, of the first state of laws, and
  /// past the last of all.
  [[nodiscard]] int windings() const { return 2 * size(); }
  [[nodiscard]] int bristles() const;
  [[nodiscard]] int law_states() const;
  [[nodiscard]] int states() const;
  [[nodiscard]] const Laws& laws() const { return laws_; }
  /// Whether a contact is with compliant ground: a force, no constraint.
  [[nodiscard]] bool compliant(int i) const { return compliant_ && i < points_; }
  /// A weight, beside which forces are small or large [N].
  [[nodiscard]] double force_scale() const { return force_scale_; }
  /// Of evaluate(), so far.
  [[nodiscard]] long evaluations() const { return evaluations_; }
  [[nodiscard]] const std::vector<MotorState>& motors() const { return drive_.motors; }
  /// A joint's angle on its motor's side at a state [rad], and its rate [rad/s].
  [[nodiscard]] double motor_position(int motor, const State& y) const {
    return mechanism_.motor_angle(motor, y.data());
  }
  [[nodiscard]] double motor_velocity(int motor, const State& y) const {
    return mechanism_.motor_rate(motor, y.data() + size());
  }

  // What acts on it.
  [[nodiscard]] const Inputs& inputs() const { return inputs_; }
  /// Takes what changes by a jump at t: commands, pushes. A loop that can't close: nothing.
  void take_inputs(double t, const State& y);
  /// Commands torques before their gears [N m], one a motor, until the controller's first command.
  void hold(const std::vector<double>& torques);

  // What follows from a state. Null where a loop can't close or M is singular.
  const std::vector<ContactState>* contacts(const State& y);
  const Inertia* inertia(const State& y);
  const ContactRows* rows(const State& y, const std::vector<int>& touching);
  /// Hinges and joints that rub, as they settle at y; none where there are no such parts.
  const FastParts& fast_parts(const State& y, const std::vector<Touch>& modes);
  /// The same without responses, at y, where the last evaluation was.
  void fast_slopes(const State& y, std::vector<FastPart>& parts);
  /// Generalised forces less the bias, Q - h, without rigid contacts.
  const double* balance(double t, const State& y, const std::vector<Touch>& modes);
  /// What Coulomb's law asks of contacts: w their accelerations at (t, y), or their rates.
  const ContactSystem* acceleration_system(double t, const State& y,
                                           const std::vector<Touch>& modes,
                                           const std::vector<int>& touching);
  const ContactSystem* rate_system(const State& y, const std::vector<int>& touching);
  /// The whole right-hand side at `modes`; null also where the contacts are singular.
  const Evaluation* evaluate(double t, const State& y, const std::vector<Touch>& modes,
                             State& dydt);
  /// Motors and bus alone, at (t, y); all else stands as it was. False where laws change what
  /// motors do: that takes the whole right-hand side.
  bool sample_drive(double t, const State& y, DriveSample& out);

 private:
  bool place(const State& y);
  bool weigh(const State& y);
  bool fill_rows(const State& y, const std::vector<int>& touching);
  void read_motors(const State& y);
  double set_drive(double t, const State& y);
  void set_forces(double t, const State& y, const std::vector<Touch>& modes);
  void add_ground(const State& y, const std::vector<Touch>& modes);
  void add_push(const Push& push, double t, const double* q, const double* v);
  void set_accelerations();
  bool add_contacts(const State& y, const std::vector<Touch>& modes, double* acceleration);
  void take_changes(const PlantChanges& changes);
  void set_slow_rates(const State& y, State& dydt) const;
  void list_touching(const std::vector<Touch>& modes);

  const Plant& plant_;
  Mechanism mechanism_;
  Drive drive_;
  Inputs inputs_;
  PassiveForces passive_;
  Laws laws_;
  CompliantGround ground_;
  std::vector<Unilateral> unilaterals_;
  int points_ = 0;  ///< feet and ground points, which come first among the unilaterals
  bool compliant_ = false;
  bool warm_ = false;  ///< windings' temperatures are states
  double force_scale_ = 1.0;
  long evaluations_ = 0;

  // What stands at `placed_`, (q, v): each of these needs the one before it.
  State placed_;          ///< empty: nothing stands
  bool weighed_ = false;  ///< the inertia does
  bool rowed_ = false;    ///< the rows do
  Inertia inertia_;
  ContactRows rows_;
  Evaluation at_;
  std::vector<double> motor_position_;  ///< joint angles on the motors' side [rad]
  std::vector<double> motor_velocity_;  ///< [rad/s]
  ContactSystem system_;
  std::array<double, kMaxSize> force_, balance_;
  std::array<double, kMaxSize> free_;  ///< L^-1 (Q - h)
  FastParts fast_;
  std::vector<int> touching_;
  std::vector<Touch> touching_modes_;
};

}  // namespace jaculus::simulation::detail
