#pragma once
// Where every variable of the nonlinear program stands: the sole owner of column indices.
//
// Order of the columns (n coordinates, n_u inputs):
//   phase by phase, along time:  node [q (n), v (n)], interval's input [u (n_u)], node, input,
//                                ..., node
//   (inputs linear over an interval: a phase's node k is followed by its input u_k, the last node
//   too), then the durations of the phases, then the extra variables that terms asked for (a time
//   of flight, an impulse).
// A phase begins with the last node of the phase before it, unless a foot touches down there: then
// it has a node of its own and the impact joins the two.

#include <string>
#include <vector>

#include "jaculus/components/equations.h"
#include "jaculus/transcription/problem.h"

namespace jaculus::transcription {

struct NodeBlock {
  int phase = 0;   ///< phase in which it was made (a shared node belongs to the earlier one)
  int number = 0;  ///< within that phase
  int q = 0;       ///< column of the first position
  int v = 0;       ///< column of the first velocity
};

struct IntervalBlock {
  int phase = 0;
  int number = 0;               ///< within the phase
  int first = 0, last = 0;      ///< nodes
  int u_first = 0, u_last = 0;  ///< columns of the inputs at its ends; equal where held
  double fraction = 0.0;        ///< of the phase's duration
  double begin = 0.0;           ///< fraction of the phase's duration that lies before it
};

struct PhaseBlock {
  std::string name;
  std::vector<int> feet;     ///< feet in contact
  std::vector<int> landing;  ///< those of them that the phase before lacked
  int duration = 0;          ///< column
  int first_interval = 0, last_interval = 0;
  int first_node = 0, last_node = 0;
};

/// An extra variable that a term asked for.
struct ExtraVariable {
  std::string name, unit;
  Bounds bounds;
  double scale = 1.0;
  double guess = 0.0;
};

/// Bounds, scale and name of one column are filled by make_layout; terms may tighten bounds and add
/// extra variables.
struct Layout {
  int n = 0;    ///< coordinates
  int n_u = 0;  ///< inputs
  bool held = true;
  std::vector<NodeBlock> nodes;
  std::vector<IntervalBlock> intervals;
  std::vector<PhaseBlock> phases;
  int first_extra = 0;

  Vector lower, upper, scale;  ///< one a column
  std::vector<std::string> names, units;
  std::vector<double> extra_guess;

  [[nodiscard]] int columns() const { return count_of(lower); }
  /// Appends a variable; returns its column.
  int add_variable(const ExtraVariable& variable);
};

/// Lays out the variables of a problem. Bounds of positions, velocities, inputs and durations come
/// from the problem where it states them, else from the robot. Contradictions are InputErrors at
/// the problem's place.
Layout make_layout(const Problem& problem, const components::Equations& equations);

/// Largest joint torque a plan may use of a motor of the model: the tighter of torque and current
/// limits [N m, N where it slides]. Of it an input is bounded by what dry friction leaves,
/// whichever way the joint turns.
double usable_torque(const Problem& problem, const model::PlanarModel& model,
                     const model::PlanarMotor& motor);

}  // namespace jaculus::transcription
