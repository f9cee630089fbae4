#include "jaculus/simulation/simulate.h"

#include <fmt/format.h>

#include "simulation/integrate/run.h"

namespace jaculus::simulation {

const char* status_name(SimulationStatus status) {
  switch (status) {
    case SimulationStatus::done:
      return "done";
    case SimulationStatus::diverged:
      return "diverged";
    case SimulationStatus::event_cluster:
      return "event_cluster";
    case SimulationStatus::singular:
      return "singular";
    case SimulationStatus::contact_unresolved:
      return "contact_unresolved";
  }
  return "";
}

Simulation simulate(const Plant& plant, const Controller& controller, const StartState& start,
                    const SimulationOptions& options) {
  detail::Run run(plant, controller, start, options);
  detail::Outcome failed = detail::start_run(run);
  if (!failed) failed = detail::advance(run);
  if (!failed) detail::record_end(run);

  Simulation out = run.recorder.take();
  if (failed) {
    out.status = failed->status;
    out.message = fmt::format("at {:.6f} s: {}", run.state.t, failed->message);
  }
  out.end_time = run.state.t;
  out.events = std::move(run.state.events);
  out.evaluations = run.equations.evaluations();
  return out;
}

}  // namespace jaculus::simulation
