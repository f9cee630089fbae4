#pragma once
// The loop of a simulation: steps of Dormand-Prince 5(4) between instants at which something jumps (commands, pushes), events
// located on its dense output, transitions of the contacts. A step that the next command ends anyway is first tried with the
// classical method of Kutta, whose four evaluations (the last is the next step's first) are two less:
//     y1 = y + h/6 (k1 + 2 k2 + 2 k3 + k4),   error estimate h/6 (k4 - f(y1)),   dense output the cubic through y, y1, k1, f(y1).
// The estimate is that of the embedded method of order three (weights 1/6, 1/3, 1/3, 0 and 1/6 on f(y1); Hairer, Norsett and Wanner,
// Solving Ordinary Differential Equations I, section II.4), so the step itself, of order four, errs by much less than the tolerance.
//
// Why these integrators: a held command ends a step each millisecond or less, over which the motion is smooth, so one explicit step
// meets 1e-6 with four evaluations of a microsecond each; multistep methods (CVODE) would restart at every
// command, and ARKODE's root finding evaluates event functions on an interpolant all the same. Event functions of forces need the
// equations themselves: they are evaluated at the ends of a step, where they come for free, and where one has changed its sign
// the instant is bracketed on the dense output by Boost's toms748. A gap that closes and opens again within a step is found from
// the sign of its rate.

#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <vector>

#include "simulation/plant_equations.h"

namespace jaculus::detail {

/// A rate that counts as zero; above what is left of one that a contact holds at zero [m/s, rad/s].
inline constexpr double kStill = 2e-7;

class Simulator {
 public:
  Simulator(const Plant& plant, const Controller& controller, const StartState& start,
            const SimulationOptions& options);
  Simulation run();

 private:
  using State = std::vector<double>;
  using Stepper = boost::numeric::odeint::runge_kutta_dopri5<State>;
  /// What must not fall below zero within a step: a gap, a depth, a normal force, the two sides of the cone, the rate of a slip.
  enum class Function { gap, height, lift, cone_plus, cone_minus, slide };
  struct EventFunction {
    Function kind;
    int contact;
    double tolerance;
    double at_start = 0.0, at_end = 0.0;
    double rate_at_start = 0.0;  ///< of a gap
  };

  void prepare(const StartState& start);
  bool enter(double t);
  bool evaluate_start();
  bool step(double limit);
  bool attempt(double limit);
  bool attempt_short();
  bool derive(double t, const State& y, State& dydt);
  double worst_error();
  bool handle_events();
  [[nodiscard]] double value(const EventFunction& f) const;
  [[nodiscard]] bool forces_at(const EventFunction& f) const {
    return f.kind != Function::gap && f.kind != Function::slide;
  }
  double value_at(const EventFunction& f, double t, double shift);
  double first_crossing(const EventFunction& f);
  [[nodiscard]] bool dips(EventFunction& f, double& bottom);
  void list_functions();
  void log_limits();
  void dense(double t, State& out);
  bool transition(const EventFunction& f);
  bool sink();
  bool rest();
  bool stand();
  bool close_gaps(const std::vector<int>& touching);
  bool come_to_rest(const std::vector<int>& touching);
  void compliant_transition(const EventFunction& f);
  void label_soles();
  bool impact();
  bool settle(const Touch* excluded, int excluded_contact);
  void limit_rebound(const std::vector<int>& touching, const Touch* modes);
  bool project();
  bool record_before(double t);
  void record(double t, const State& y);
  bool fail(SimulationStatus status, const std::string& message);
  void log(EventKind kind, int contact);
  void set_mode(int contact, Touch mode);
  [[nodiscard]] std::vector<int> candidates(bool approaching) const;
  [[nodiscard]] bool touching_anything() const;

  SimulationOptions options_;
  PlantEquations equations_;
  Stepper stepper_;
  State y_, dydt_, y_new_, dydt_new_, error_, y_dense_, dydt_dense_, y_stage_, k2_, k3_, k4_;
  std::vector<EventFunction> functions_;
  double t_ = 0.0, t_new_ = 0.0, step_ = 0.0, h_ = 1e-3;
  bool broken_ = false;  ///< the equations failed within a step
  bool short_ = false;   ///< the step is one of the short method
  int pause_ = 0;        ///< steps for which the short method rests
  bool stands_ = false;  ///< the equations stand at (t_, y_) and the present modes
  bool touched_ = false;
  int crowded_ = 0, transitions_ = 0;
  std::vector<bool> limited_;
  double last_event_ = -1.0;
  Eigen::Index sample_ = 0;
  Simulation out_;
};

}  // namespace jaculus::detail
