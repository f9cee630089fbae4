#pragma once
// Steps of a W-method of order 3(2), L-stable and stiffly accurate, for motions with parts far
// faster than what is asked of them: a joint that dry friction holds, a stiff hinge behind a rotor
// of hardly any inertia. A step's length is set by the motion's accuracy, never by such a part.
//
// Rosenbrock methods need df/dy to machine precision, one evaluation a state and step. A W-method
// keeps its order with any matrix in its place, and is stable where the fast parts are in it: those
// are known, each one row r of rates with d(dv/dt)/dv = -damping a r^T, d(dv/dt)/dq = -stiffness
// a r^T, a the accelerations by a unit of its force (fast_part.h). So a step takes four
// evaluations, as many as an explicit one. With J of these and dq/dt = v, stage i solves
//     (I/(gamma h) - J) u_i = f(t + c_i h, y + sum_j a_ij u_j) + sum_j c_ij u_j/h,
//     y(t + h) = y + sum_i m_i u_i,   error = (I - gamma h J)^-1 sum_i e_i u_i.
// An error of a fast part is forgotten as the part settles: the inverse counts what is left of it
// (as RADAU5 does; Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8).
// What is left of a rate that settles by r = damping a^T row in a second moves its coordinate by
// error/r and no more. Rates are granted g = kGrantedRate times what coordinates are, as errors of
// theirs last for some 1/g; so this one counts by g/r. That holds of a joint that is about to rest:
// one whose friction can't hold it passes through, with its error. A part that is fast no more at
// the step's end (a joint that breaks away) forgets nothing: where one has changed by a factor of
// two the error is sum_i e_i u_i itself.
// What is stiff beside these parts (compliant ground, states of users' laws, a motor's damping
// behind a stiff hinge) is as in an explicit method.
// Coefficients: ROS34PW2 (Rang and Angermann, New Rosenbrock W-methods of order 3 for partial
// differential algebraic equations of index 1, BIT 45, 2005), in the form without products by J
// (Hairer and Wanner, section IV.7).

#include <Eigen/LU>
#include <array>
#include <functional>
#include <vector>

#include "jaculus/core/types.h"
#include "simulation/integrate/step.h"
#include "simulation/plant/fast_part.h"

namespace jaculus::simulation::detail {

/// Fast parts at a state at which f was evaluated last, without responses.
using FastSlopes = std::function<void(const State& y, std::vector<FastPart>& parts)>;

class ImplicitMethod {
 public:
  /// Takes `step` over its length: sets y_end and dydt_end, and `error`, an estimate of the error
  /// of y_end. The last evaluation of f is at the end. `fast`: those at the step's start; `slopes`
  /// at a state.
  void take(const RightHandSide& f, const FastParts& fast, const FastSlopes& slopes, Step& step,
            State& error);
  /// The state at t within the last step: coordinates by the cubic through both ends and their
  /// rates; the others, whose rates may jump at the start, by the parabola that ends as the step.
  void dense(const Step& step, double t, State& out) const;

  static constexpr double kEvaluations = 4.0;  ///< of a step
  /// Absolute tolerance of rates beside that of coordinates [1/s].
  static constexpr double kGrantedRate = 100.0;

 private:
  using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxSize, kMaxSize>;
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSize, 1>;

  void factorise(const FastParts& fast, double inverse);
  void solve(const FastParts& fast, double inverse, State& x) const;
  /// Takes off an error of the rates what parts that come to rest will have forgotten.
  void forget(const FastParts& fast, const double* accelerations, double* rates);

  int size_ = 0;  ///< coordinates
  std::array<State, 4> u_;
  /// I/(gamma h) + sum (damping + gamma h stiffness) a r^T: of the rates, coordinates eliminated
  Eigen::PartialPivLU<SmallMatrix> factors_;
  State at_, rate_;
  std::vector<FastPart> at_end_;
  std::vector<int> settling_;  ///< parts whose errors are forgotten
};

}  // namespace jaculus::simulation::detail
