#pragma once
// A step of a motion in time, whatever the method.

#include <functional>
#include <vector>

namespace jaculus::simulation::detail {

using State = std::vector<double>;
/// y' at (t, y); false where the equations fail.
using RightHandSide = std::function<bool(double t, const State& y, State& dydt)>;

enum class Method { kutta, dormand_prince, implicit };

/// A step that was taken: both of its ends, with their rates.
struct Step {
  double t = 0.0;       ///< where it starts [s]
  double length = 0.0;  ///< [s]
  double end = 0.0;     ///< where it ends: its limit exactly, or t + length [s]
  State y, dydt;        ///< at its start
  State y_end, dydt_end;
  Method method = Method::dormand_prince;
};

}  // namespace jaculus::simulation::detail
