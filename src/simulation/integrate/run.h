#pragma once
// A run and what leads it through its time, in the order in which it happens:
//     start_run    contacts, equilibrium of loose parts, impacts, torques that hold the pose
//     advance      until the end: take_step, end_step (the first event ends it), and where inputs
//                  jump, take_jump
//     record_end   the last sample

#include <string>
#include <vector>

#include "simulation/contact/transitions.h"
#include "simulation/integrate/events.h"
#include "simulation/integrate/recorder.h"
#include "simulation/integrate/stepper.h"

namespace jaculus::simulation::detail {

/// All that takes part in a run.
struct Run {
  /// InputError where they don't fit one another. They must outlive it.
  Run(const Plant& plant, const Controller& controller, const StartState& start,
      const SimulationOptions& options);

  const SimulationOptions& options;
  PlantEquations equations;
  Stepper stepper;
  Recorder recorder;
  RunState state;
  std::vector<EventFunction> functions;  ///< of the step that comes
  std::vector<bool> limited;             ///< motors at a limit
};

Outcome start_run(Run& run);
Outcome advance(Run& run);
void record_end(Run& run);

/// Rates and event functions at the start of a step; contacts that its forces contradict change
/// their mode.
Outcome begin_step(Run& run);
/// The run goes on from the first event of a step, or from its end where there is none. `at_end`:
/// the evaluation there.
Outcome end_step(Run& run, Step& step, const Evaluation& at_end);

/// That the equations of motion are singular.
Fault singular_motion(const std::string& where);

}  // namespace jaculus::simulation::detail
