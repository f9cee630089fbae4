#pragma once
// Steps of a Rosenbrock method of order 4(3), L-stable, for motions with parts far faster than what
// is asked of them: a stiff hinge behind a rotor of hardly any inertia settles within a
// microsecond. A step's length is set by the motion's accuracy, never by such a part.
//
// RODAS (Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.7), of which
// Boost.Odeint has the coefficients; its own stepper needs uBLAS, which C++20 no longer compiles.
// With W = I/(gamma h) - df/dy, stage i solves
//     W g_i = f(t + c_i h, y + sum_j a_ij g_j) + h d_i df/dt + sum_j c_ij g_j/h,
// the last two at the end of the step; the last one is the error estimate. df/dy and df/dt are
// forward differences, one evaluation a state.

#include <Eigen/LU>
#include <array>

#include "jaculus/core/types.h"
#include "simulation/integrate/step.h"

namespace jaculus::simulation::detail {

class ImplicitMethod {
 public:
  /// Takes `step` over its length: sets y_end and dydt_end, and `error`, an estimate of the error
  /// of y_end. The last evaluation of f is at the end.
  void take(const RightHandSide& f, Step& step, State& error);
  /// The state at t within the last step, a cubic.
  void dense(const Step& step, double t, State& out) const;

  /// Evaluations of f that a step takes.
  static int evaluations(int states) { return states + 7; }

 private:
  void set_slopes(const RightHandSide& f, const Step& step);

  std::array<Vector, 6> g_;
  Matrix by_state_;  ///< df/dy
  Vector by_time_;   ///< df/dt
  Eigen::PartialPivLU<Matrix> factors_;
  State at_, rate_;
};

}  // namespace jaculus::simulation::detail
