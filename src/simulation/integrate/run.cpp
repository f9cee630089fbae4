#include "simulation/integrate/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"

namespace jaculus::simulation::detail {

namespace {

constexpr double kMostEvaluations = 5e5;  ///< of the equations, and
/// so many more a second of motion: a thousand times what a leap takes
constexpr double kMostRate = 4e6;
/// Rate of a coordinate beyond which a motion has diverged; turbines turn at a tenth [rad/s, m/s].
constexpr double kFastest = 1e5;

RunState start_state(const PlantEquations& equations, const StartState& start) {
  const int n = equations.model_size();
  if (start.q.size() != n || start.v.size() != n)
    throw InputError(fmt::format("the start has {} coordinates and {} rates; the robot has {}",
                                 start.q.size(), start.v.size(), n));

  RunState state;
  state.y.assign(equations.states(), 0.0);
  state.dydt = state.y;
  state.modes.assign(equations.unilaterals().size(), Touch::open);
  for (int i = 0; i < n; ++i) {
    state.y[i] = start.q[i];
    state.y[equations.size() + i] = start.v[i];
  }
  for (int i = equations.windings(); i < equations.bristles(); ++i)
    state.y[i] = equations.plant().winding.initial;
  equations.laws().start(state.y.data() + equations.law_states());
  return state;
}

/// "; front_extension is at 3.1, beyond its range 0.4 to 2.74" for the coordinate that is furthest
/// outside, or nothing.
std::string beyond_range(const model::PlanarModel& model, const State& y) {
  const model::Coordinate* worst = nullptr;
  double furthest = 0.0, value = 0.0;
  for (int i = 0; i < model.size(); ++i) {
    const model::Coordinate& c = model.coordinates[i];
    const double outside = std::max(c.range.lower - y[i], y[i] - c.range.upper);
    if (!(outside > furthest)) continue;
    worst = &c;
    furthest = outside;
    value = y[i];
  }

  if (worst == nullptr) return "";
  return fmt::format(
      "; {} is at {:.4g}, beyond its range {:.4g} to {:.4g}, and no stop holds it there",
      worst->name, value, worst->range.lower, worst->range.upper);
}

}  // namespace

Run::Run(const Plant& plant, const Controller& controller, const StartState& start,
         const SimulationOptions& given)
    : options(given),
      equations(plant, controller),
      stepper(given.relative_tolerance, given.absolute_tolerance, equations.size(),
              equations.states(),
              [this](const State& y, std::vector<FastPart>& parts) {
                equations.fast_slopes(y, parts);
              }),
      recorder(equations, given.sample_times, given.sampled),
      state(start_state(equations, start)),
      limited(equations.motors().size(), false) {}

Fault singular_motion(const std::string& where) {
  return {SimulationStatus::singular, "the equations of motion are singular" + where};
}

// Where a step begins
// -------------------------------------------------------------------------------------------------

namespace {

/// Motors that have come to a limit, as events.
void log_limits(Run& run) {
  for (int m = 0; m < count_of(run.limited); ++m) {
    const bool now = run.equations.motors()[m].limited;
    if (now && !run.limited[m])
      run.state.events.push_back(
          {run.state.t, EventKind::limit, run.equations.plant().model.motors[m].joint});
    run.limited[m] = now;
  }
}

}  // namespace

Outcome begin_step(Run& run) {
  RunState& s = run.state;
  for (int attempts = 0; attempts < 3; ++attempts) {
    const Evaluation* at = run.equations.evaluate(s.t, s.y, s.modes, s.dydt);
    if (at == nullptr) return singular_motion("");
    list_functions(run.equations, s.modes, run.options.contact_tolerance, run.functions);
    if (begin(run.equations, *at, run.functions)) {
      while (run.recorder.next() <= s.t) run.recorder.record(run.equations, s.y, at);
      log_limits(run);
      return {};
    }
    if (Outcome failed = resolve_modes(run.equations, run.options.contact_tolerance, {}, s))
      return failed;
  }

  return Fault{SimulationStatus::contact_unresolved,
               "contacts find no mode that their forces agree with"};
}

Outcome start_run(Run& run) {
  PlantEquations& equations = run.equations;
  RunState& s = run.state;
  const double tolerance = run.options.contact_tolerance;
  if (equations.contacts(s.y) == nullptr)
    return Fault{SimulationStatus::singular, "the start's loops can't be closed"};

  equations.take_inputs(s.t, s.y);
  if (Outcome failed = initialise_contacts(equations, tolerance, s)) return failed;
  if (Outcome failed = find_static_equilibrium(equations, s)) return failed;
  if (Outcome failed = resolve_impact(equations, tolerance, s)) return failed;
  if (equations.inputs().waiting())
    if (Outcome failed = hold_pose(equations, tolerance, s)) return failed;
  return begin_step(run);
}

namespace {

/// Inputs jump between two steps.
Outcome take_jump(Run& run) {
  run.equations.take_inputs(run.state.t, run.state.y);
  return begin_step(run);
}

// Steps
// -------------------------------------------------------------------------------------------------

/// A step from the run's state that ends at `limit` or before; `at_end`: the evaluation there.
Outcome take_step(Run& run, double limit, Step& step, const Evaluation*& at_end) {
  step.t = run.state.t;
  step.y = run.state.y;
  step.dydt = run.state.dydt;
  run.stepper.expect(run.equations.fast_parts(step.y, run.state.modes));
  const auto rates = [&run, &at_end](double t, const State& y, State& dydt) {
    at_end = run.equations.evaluate(t, y, run.state.modes, dydt);
    return at_end != nullptr;
  };
  const StepResult result = run.stepper.take(rates, limit, step);

  const auto outside = [&] { return beyond_range(run.equations.plant().model, run.state.y); };
  const auto diverged = [&](const std::string& what) {
    return Fault{SimulationStatus::diverged, what + outside()};
  };
  if (result == StepResult::equations_fail) return singular_motion(outside());
  if (result == StepResult::no_step_is_short_enough)
    return diverged("the motion diverges: no step is short enough");
  if (run.equations.evaluations() >
      std::llround(kMostEvaluations + kMostRate * run.options.duration))
    return diverged("the motion asks for ever shorter steps");
  return {};
}

/// A fault where something moves faster than any machine.
Outcome check_rates(const Run& run) {
  const int n = run.equations.size();
  for (int i = 0; i < n; ++i)
    if (std::abs(run.state.y[n + i]) > kFastest)
      return Fault{SimulationStatus::diverged,
                   "the motion diverges: a joint or the body moves at more than 1e5 rad/s or m/s"};
  return {};
}

}  // namespace

/// Steps between the instants at which inputs jump, to the end of the run or to a fault.
Outcome advance(Run& run) {
  const RunState& s = run.state;
  Step step;
  while (s.t < run.options.duration) {
    const double change = run.equations.inputs().next_change(s.t);
    const Evaluation* at_end = nullptr;
    if (Outcome failed = take_step(run, std::min(change, run.options.duration), step, at_end))
      return failed;
    if (Outcome failed = end_step(run, step, *at_end)) return failed;
    if (Outcome failed = check_rates(run)) return failed;
    if (run.options.stop_at_lift_off && s.touched && !touches_floor(run.equations, s)) break;
    if (s.t == change)
      if (Outcome failed = take_jump(run)) return failed;
  }
  return {};
}

/// A sample at the very end.
void record_end(Run& run) {
  RunState& s = run.state;
  if (run.recorder.next() > s.t) return;
  const Evaluation* at = run.equations.evaluate(s.t, s.y, s.modes, s.dydt);
  run.recorder.record(run.equations, s.y, at);
}

}  // namespace jaculus::simulation::detail
