#pragma once
// Events within a step: what must not fall below zero, and the first instant at which something
// does. Event functions of forces need the equations themselves: they are evaluated at the ends of
// a step, where they come for free, and where one has changed its sign the instant is bracketed on
// the dense output by Boost's toms748. A gap that closes and opens again within a step is found
// from the sign of its rate.

#include <optional>
#include <vector>

#include "simulation/contact/plant_equations.h"
#include "simulation/integrate/stepper.h"

namespace jaculus::simulation::detail {

/// What must not fall below zero within a step: a gap, a depth, a normal force, the two sides of
/// the cone, the rate of a slip.
enum class EventFunctionKind { gap, depth, lift, cone_plus, cone_minus, slide };

struct EventFunction {
  EventFunctionKind kind;
  int contact;
  Touch mode;        ///< of the contact
  double tolerance;  ///< below which it counts as zero, in its own unit
  double at_start = 0.0, at_end = 0.0;
  double rate_at_start = 0.0;  ///< of a gap

  /// Whether it takes an evaluation of forces; else positions and rates are enough.
  [[nodiscard]] bool needs_forces() const {
    return kind != EventFunctionKind::gap && kind != EventFunctionKind::slide;
  }
};

/// The equations' right-hand side at these modes; both must outlive it.
RightHandSide rates_of(PlantEquations& equations, const std::vector<Touch>& modes);

/// Those of every contact at its mode.
void list_functions(const PlantEquations& equations, const std::vector<Touch>& modes,
                    double contact_tolerance, std::vector<EventFunction>& out);

/// Sets `at_start` of all of them; whether none of the forces contradicts its mode.
bool begin(const PlantEquations& equations, const Evaluation& at,
           std::vector<EventFunction>& functions);

/// Something fell below zero within a step.
struct Occurrence {
  EventFunction function;
  double time;  ///< [s]
};
/// What a step has come upon.
struct StepEvents {
  std::optional<Occurrence> first;
  bool searched = false;  ///< the equations stand elsewhere than at the step's end
};
/// The first event of a step, with `at` the evaluation at its end. Sets `at_end` of the functions.
StepEvents find_events(PlantEquations& equations, Stepper& stepper, const Step& step,
                       const Evaluation& at, const std::vector<Touch>& modes,
                       std::vector<EventFunction>& functions);

}  // namespace jaculus::simulation::detail
