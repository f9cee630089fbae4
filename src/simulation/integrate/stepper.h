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
//
// Explicit methods are stable up to a length of 3.3/r, r: the fastest rate of the equations. The
// implicit method is taken where its steps, as accuracy allows them, are so much longer that they
// take fewer evaluations; where they turn out not to be, it rests.

#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>

#include "simulation/integrate/implicit_method.h"
#include "simulation/integrate/step.h"

namespace jaculus::simulation::detail {

enum class StepResult { accepted, no_step_is_short_enough, equations_fail };

class Stepper {
 public:
  /// The absolute tolerance is that of coordinates; their rates, which come next, are granted a
  /// hundred times as much a second: measured, a leap with dry friction is as exact as with one for
  /// all, 3e-7 rad by 1e-8, in three quarters of the time.
  /// `slopes`: of what is fast, at any state.
  Stepper(double relative_tolerance, double absolute_tolerance, int coordinates, int states,
          FastSlopes slopes);

  /// Tells what is fast in the equations where the next step begins; must outlive it.
  void expect(const FastParts& fast) {
    fast_ = &fast;
    fastest_rate_ = fast.rate();
  }

  /// Fills `step`, which has t, y and dydt, with one that meets the tolerances and ends at `limit`
  /// or before. The last evaluation of f is at its end.
  StepResult take(const RightHandSide& f, double limit, Step& step);
  /// The state at t within the last step that was taken, by its interpolant.
  void dense(const Step& step, double t, State& out);
  /// The same as exact as the step, for forces: those of fast parts follow no interpolant.
  void state_at(const RightHandSide& f, const Step& step, double t, State& out);
  /// The motion changed: the next step need not be as short as the last.
  void restart();

 private:
  bool attempt(const RightHandSide& f, double limit, Step& step);
  bool attempt_implicit(const RightHandSide& f, double limit, double least, Step& step);
  bool attempt_kutta(const RightHandSide& f, Step& step);
  bool accept(double order, double& next, const Step& step);
  static bool set_length(double next, double left, Step& step);
  [[nodiscard]] double paying_length() const;
  [[nodiscard]] double turning_length(const Step& step) const;
  double worst_error(const Step& step);
  [[nodiscard]] bool bends(const Step& step) const;

  double relative_tolerance_;
  State absolute_tolerance_;  ///< of each state
  boost::numeric::odeint::runge_kutta_dopri5<State> dopri5_;
  ImplicitMethod implicit_;
  const FastParts* fast_ = nullptr;
  FastSlopes slopes_;
  double fastest_rate_ = 0.0;      ///< [1/s]
  double next_length_ = 1e-3;      ///< of an explicit step [s]
  double implicit_length_ = 1e-3;  ///< [s]
  int pause_ = 0;                  ///< steps for which Kutta's method rests
  int implicit_pause_ = 0;         ///< steps for which the implicit one does
  bool broken_ = false;            ///< the equations failed within the step
  State error_, y_stage_, k2_, k3_, k4_;
};

}  // namespace jaculus::simulation::detail
