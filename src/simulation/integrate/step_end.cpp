// Where a step ends: at its first event, or at its limit; drift, samples, what contacts do then.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulation/integrate/run.h"

namespace jaculus::simulation::detail {

namespace {

constexpr double kDriftTime = 0.1;   ///< over which a rate of drift counts as a drift [s]
constexpr int kCrowd = 60;           ///< events within kCrowdTime that make a cluster
constexpr double kCrowdTime = 1e-7;  ///< [s]

/// Takes drift off the closed contacts where it is more than a trace: the least change of positions
/// and rates y by the mass matrix' measure. `at`: the evaluation there.
void project(Run& run, const Evaluation& at, State& y) {
  const std::vector<Touch>& now = run.state.modes;
  std::vector<int> closed;
  Touch modes[kMaxTouching] = {};
  double drift = 0.0;
  for (int i = 0; i < count_of(now); ++i) {
    if (now[i] == Touch::open || run.equations.compliant(i)) continue;
    const bool sticks = now[i] == Touch::stick;
    modes[closed.size()] = sticks ? Touch::stick : Touch::slip_plus;
    closed.push_back(i);
    const ContactState& c = at.contacts[i];
    drift = std::max({drift, std::abs(c.gap), kDriftTime * std::abs(c.normal_rate),
                      sticks ? kDriftTime * std::abs(c.tangential_rate) : 0.0});
  }
  if (drift <= 1e-4 * run.options.contact_tolerance) return;

  // both by the rows and the mass matrix before the change
  const State unprojected = y;
  const ContactRows& rows = *run.equations.rows(unprojected, closed);
  const Inertia& inertia = *run.equations.inertia(unprojected);
  for (const bool rates : {false, true}) {
    ContactSystem s;
    rows.set_system(run.equations.unilaterals(), s);
    for (int k = 0; k < s.count; ++k) {
      const ContactState& c = at.contacts[closed[k]];
      if (modes[k] != Touch::stick) s.mu[k] = 0.0;
      s.b[2 * k] = rates ? c.tangential_rate : 0.0;
      s.b[2 * k + 1] = rates ? c.normal_rate : c.gap;
    }
    if (solve_at(s, modes))
      rows.add_response(inertia, s.lambda, y.data() + (rates ? run.equations.size() : 0));
  }
}

/// Samples within the step and before t: the motion, and motors by it, by the step's interpolant;
/// contacts' forces where it is exact. Whether the equations were evaluated.
bool record_before(Run& run, const Step& step, double t) {
  const Sampled what = run.options.sampled;
  if (run.recorder.next() >= t) return false;
  State y(step.y.size()), dydt(step.y.size());
  DriveSample drive;
  bool evaluated = what == Sampled::all && step.method == Method::implicit;  // by state_at()
  while (run.recorder.next() < t) {
    const double at = run.recorder.next();
    if (what == Sampled::all)
      run.stepper.state_at(rates_of(run.equations, run.state.modes), step, at, y);
    else
      run.stepper.dense(step, at, y);

    if (what == Sampled::motion) {
      run.recorder.record(run.equations, y, nullptr);
    } else if (what == Sampled::motors && run.equations.sample_drive(at, y, drive)) {
      run.recorder.record(run.equations, y, drive);
    } else {
      run.recorder.record(run.equations, y, run.equations.evaluate(at, y, run.state.modes, dydt));
      evaluated = true;
    }
  }
  return evaluated;
}

/// Modes of the contact that an event is of, and of those that it carries along.
Outcome change_contacts(Run& run, const EventFunction& event) {
  PlantEquations& equations = run.equations;
  RunState& s = run.state;
  if (++s.transitions > run.options.max_events)
    return Fault{SimulationStatus::event_cluster,
                 fmt::format("more than {} contact events", run.options.max_events)};
  s.crowded = s.t - s.last_event < kCrowdTime ? s.crowded + 1 : 0;
  s.last_event = s.t;
  if (s.crowded > kCrowd)
    return Fault{SimulationStatus::event_cluster,
                 fmt::format("contact events of '{}' follow one another without end",
                             equations.unilaterals()[event.contact].name)};

  const bool lands = event.kind == EventFunctionKind::gap;
  if (equations.compliant(event.contact)) {  // no impulse where the ground gives way
    set_mode(equations, event.contact, lands ? Touch::stick : Touch::open, s);
    return {};
  }
  const double tolerance = run.options.contact_tolerance;
  if (lands) return resolve_impact(equations, tolerance, s);
  return resolve_modes(equations, tolerance, ExcludedMode{event.contact, event.mode}, s);
}

/// The run goes on from an event within the step.
Outcome end_at_event(Run& run, const Step& step, const Occurrence& event) {
  record_before(run, step, event.time);
  State y(step.y.size()), dydt(step.y.size());
  run.stepper.state_at(rates_of(run.equations, run.state.modes), step, event.time, y);
  const Evaluation* at = run.equations.evaluate(event.time, y, run.state.modes, dydt);
  if (at == nullptr) return singular_motion(" at an event");
  project(run, *at, y);

  run.state.t = event.time;
  run.state.y = std::move(y);
  run.stepper.restart();
  if (Outcome failed = change_contacts(run, event.function)) return failed;
  return begin_step(run);
}

/// The run goes on from the end of the step, without an event.
void end_at_limit(Run& run, Step& step, const Evaluation& at) {
  // Whether soles on compliant ground stick or slip, for the list of events.
  for (int i = 0; i < count_of(run.state.modes); ++i)
    if (run.equations.compliant(i) && run.state.modes[i] != Touch::open)
      set_mode(run.equations, i, at.soles[i].touch, run.state);
  for (EventFunction& f : run.functions) {
    f.at_start = f.at_end;
    if (f.kind == EventFunctionKind::gap) f.rate_at_start = at.contacts[f.contact].normal_rate;
  }

  project(run, at, step.y_end);
  // The next step's slopes are those of its start, whatever was sampled before it.
  if (record_before(run, step, step.end)) {
    State dydt(step.y.size());
    run.equations.evaluate(step.end, step.y_end, run.state.modes, dydt);
  }
  run.state.t = step.end;
  run.state.y = step.y_end;
  run.state.dydt = step.dydt_end;
}

}  // namespace

Outcome end_step(Run& run, Step& step, const Evaluation& at_end) {
  const StepEvents events =
      find_events(run.equations, run.stepper, step, at_end, run.state.modes, run.functions);
  if (events.first) return end_at_event(run, step, *events.first);

  const Evaluation* at = &at_end;
  if (events.searched)
    at = run.equations.evaluate(step.end, step.y_end, run.state.modes, step.dydt_end);
  if (at == nullptr) return singular_motion("");
  end_at_limit(run, step, *at);
  return {};
}

}  // namespace jaculus::simulation::detail
