#pragma once
// Steps of Dormand-Prince 5(4). A step that a limit in time ends anyway is first tried with the
// classical method of Kutta, whose four evaluations (the last is the next step's first) are two
// less:
//     y1 = y + h/6 (k1 + 2 k2 + 2 k3 + k4),   error estimate h/6 (k4 - f(y1)),
//       dense output the cubic through y, y1, k1, f(y1).
// The estimate is that of the embedded method of order three (weights 1/6, 1/3, 1/3, 0 and 1/6 on
// f(y1); Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.4), so
// the step itself, of order four, errs by much less than the tolerance.
//
// Why these integrators: a held command ends a step each millisecond or less, over which the motion
// is smooth, so one explicit step meets 1e-6 with four evaluations of a microsecond each; multistep
// methods (CVODE) would restart at every command, and ARKODE's root finding evaluates event
// functions on an interpolant all the same.

#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <functional>
#include <vector>

namespace jaculus::simulation::detail {

using State = std::vector<double>;
/// y' at (t, y); false where the equations fail.
using RightHandSide = std::function<bool(double t, const State& y, State& dydt)>;

/// A step that was taken: both of its ends, with their rates.
struct Step {
  double t = 0.0;       ///< where it starts [s]
  double length = 0.0;  ///< [s]
  double end = 0.0;     ///< where it ends: its limit exactly, or t + length [s]
  State y, dydt;        ///< at its start
  State y_end, dydt_end;
  bool kutta = false;  ///< by Kutta's method
};

enum class StepResult { accepted, no_step_is_short_enough, equations_fail };

class Stepper {
 public:
  Stepper(double relative_tolerance, double absolute_tolerance, int states);

  /// Fills `step`, which has t, y and dydt, with one that meets the tolerances and ends at `limit`
  /// or before. The last evaluation of f is at its end.
  StepResult take(const RightHandSide& f, double limit, Step& step);
  /// The state at t within the last step that was taken.
  void dense(const Step& step, double t, State& out);
  /// The motion changed: the next step need not be as short as the last.
  void restart();

 private:
  bool attempt(const RightHandSide& f, double limit, Step& step);
  bool attempt_kutta(const RightHandSide& f, Step& step);
  double worst_error(const Step& step);

  double relative_tolerance_, absolute_tolerance_;
  boost::numeric::odeint::runge_kutta_dopri5<State> dopri5_;
  double next_length_ = 1e-3;  ///< [s]
  int pause_ = 0;              ///< steps for which Kutta's method rests
  bool broken_ = false;        ///< the equations failed within the step
  State error_, y_stage_, k2_, k3_, k4_;
};

}  // namespace jaculus::simulation::detail
