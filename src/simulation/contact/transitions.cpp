#include "simulation/contact/transitions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulation/contact/equilibrium.h"

namespace jaculus::simulation::detail {

namespace {

/// slower impacts end at rest: nothing bounces, nothing rocks on [m/s, rad/s]
constexpr double kRest = 1e-3;
constexpr int kTired = 8;  ///< so many impacts that follow one another at once end at rest together

Fault singular(const std::string& what) { return {SimulationStatus::singular, what}; }

Fault unresolved(const std::string& what) { return {SimulationStatus::contact_unresolved, what}; }

Fault too_many() {
  return unresolved(fmt::format("more than {} contacts at a time", kMaxTouching));
}

/// Contacts that take part in an impact (`approaching`: those that close at a rate too) or a change
/// of modes.
std::vector<int> candidates(const PlantEquations& equations,
                            const std::vector<ContactState>& contacts, bool approaching,
                            double tolerance, const RunState& state) {
  std::vector<int> list;
  for (int i = 0; i < count_of(state.modes); ++i) {
    if (equations.compliant(i)) continue;
    const ContactState& c = contacts[i];
    const bool near =
        c.gap <= tolerance && (approaching ? c.normal_rate <= kStill || state.crowded > kTired
                                           : std::abs(c.normal_rate) <= kStill);
    if (state.modes[i] != Touch::open || near) list.push_back(i);
  }
  return list;
}

}  // namespace

void set_mode(const PlantEquations& equations, int contact, Touch mode, RunState& state) {
  const Touch before = state.modes[contact];
  if (before == mode) return;
  const Unilateral& u = equations.unilaterals()[contact];
  if (!u.stop() && mode != Touch::open) state.touched = true;
  state.modes[contact] = mode;

  EventKind kind = mode == Touch::stick ? EventKind::stick : EventKind::slip;
  if (mode == Touch::open) kind = u.stop() ? EventKind::release : EventKind::lift;
  if (before == Touch::open) kind = u.stop() ? EventKind::stop : EventKind::land;
  state.events.push_back({state.t, kind, u.name});
}

bool touches_floor(const PlantEquations& equations, const RunState& state) {
  for (int i = 0; i < count_of(state.modes); ++i)
    if (state.modes[i] != Touch::open && !equations.unilaterals()[i].stop()) return true;
  return false;
}

Outcome initialise_contacts(PlantEquations& equations, double tolerance, RunState& state) {
  const std::vector<ContactState>* contacts = equations.contacts(state.y);
  if (contacts == nullptr) return singular("the start's loops can't be closed");

  for (int i = 0; i < count_of(state.modes); ++i) {
    const double gap = (*contacts)[i].gap;
    if (!equations.compliant(i) && gap < -tolerance)
      return unresolved(fmt::format("'{}' starts {:.3g} beyond its contact",
                                    equations.unilaterals()[i].name, -gap));
    if (equations.compliant(i) && gap <= 0.0) set_mode(equations, i, Touch::stick, state);
  }
  return {};
}

Outcome find_static_equilibrium(PlantEquations& equations, RunState& state) {
  if (!settle_loose_parts(equations, state.t, state.modes, state.y))
    return singular("hinges or a compliant floor find no equilibrium to start from");
  if (equations.inertia(state.y) == nullptr) return singular("the mass matrix is singular");
  return {};
}

Outcome resolve_modes(PlantEquations& equations, double tolerance,
                      const std::optional<ExcludedMode>& excluded, RunState& state) {
  if (equations.inertia(state.y) == nullptr)
    return singular("the equations of motion are singular");
  const std::vector<ContactState>& contacts = *equations.contacts(state.y);
  const std::vector<int> touching = candidates(equations, contacts, false, tolerance, state);
  if (count_of(touching) > kMaxTouching) return too_many();

  ContactSystem s = *equations.acceleration_system(state.t, state.y, state.modes, touching);
  s.scale_force = equations.force_scale();
  s.scale_w = 10.0;
  Touch modes[kMaxTouching] = {};
  int barred = -1;
  for (int k = 0; k < count_of(touching); ++k) {
    const double rate = contacts[touching[k]].tangential_rate;
    modes[k] = state.modes[touching[k]];
    s.moving[k] = s.mu[k] >= 0.0 && modes[k] != Touch::stick && std::abs(rate) > kStill;
    s.direction[k] = rate > 0.0 ? 1.0 : -1.0;
    if (s.moving[k] && modes[k] != Touch::open)
      modes[k] = rate > 0.0 ? Touch::slip_plus : Touch::slip_minus;
    if (excluded && touching[k] == excluded->contact) barred = k;
  }

  if (!find_modes(s, modes, barred < 0 ? nullptr : &excluded->mode, barred))
    return unresolved("no mode of the contacts agrees with Coulomb's law (jamming)");
  for (int k = 0; k < count_of(touching); ++k) set_mode(equations, touching[k], modes[k], state);
  return {};
}

Outcome hold_pose(PlantEquations& equations, double tolerance, RunState& state) {
  const Fault fault = singular("the equations of motion are singular");
  const std::vector<ContactState>* contacts = equations.contacts(state.y);
  if (contacts == nullptr) return fault;
  const std::vector<int> touching = candidates(equations, *contacts, false, tolerance, state);
  if (count_of(touching) > kMaxTouching) return too_many();

  // no event: nothing has happened yet
  for (const int i : touching) state.modes[i] = Touch::stick;
  if (!hold_by_torques(equations, state.t, state.y, state.modes)) return fault;
  return resolve_modes(equations, tolerance, {}, state);
}

// Impacts
// -------------------------------------------------------------------------------------------------

namespace {

/// Moves the robot by the trace that it is beyond contacts, so that none of them starts the next
/// step below zero. False where the mass matrix is singular.
bool close_gaps(PlantEquations& equations, const std::vector<int>& touching, State& y) {
  const ContactRows* rows = equations.rows(y, touching);
  if (rows == nullptr) return false;
  const std::vector<ContactState>& contacts = *equations.contacts(y);

  ContactSystem s;
  rows->set_system(equations.unilaterals(), s);
  Touch modes[kMaxTouching] = {};
  for (int k = 0; k < s.count; ++k) {
    modes[k] = Touch::slip_plus;
    s.mu[k] = s.b[2 * k] = 0.0;
    s.b[2 * k + 1] = contacts[touching[k]].gap;
  }
  if (solve_at(s, modes)) rows->add_response(*equations.inertia(y), s.lambda, y.data());
  return equations.inertia(y) != nullptr;
}

/// Impacts of a rocking body follow one another ever faster, without end. Slow ones end it: all
/// that touch stay closed, which is the projection of the rates on those that do so, hence takes
/// energy; the forces then say which of them open. False where they are not slow. `s`: of the
/// rates.
bool end_at_rest(PlantEquations& equations, const std::vector<int>& touching, ContactSystem s,
                 RunState& state) {
  Touch modes[kMaxTouching] = {};
  for (int k = 0; k < s.count; ++k) {
    if (s.b[2 * k + 1] < -kRest || s.b[2 * k + 1] > kRest) return false;
    const bool sticks = std::abs(s.b[2 * k]) < kRest && s.mu[k] > 0.0;
    modes[k] = sticks ? Touch::stick : Touch::slip_plus;
    if (!sticks) s.mu[k] = 0.0;
  }
  if (!solve_at(s, modes)) return false;

  equations.rows(state.y, touching)
      ->add_response(*equations.inertia(state.y), s.lambda, state.y.data() + equations.size());
  for (int k = 0; k < s.count; ++k) {
    const bool stop = equations.unilaterals()[touching[k]].stop();
    const Touch slides = s.b[2 * k] > 0.0 ? Touch::slip_plus : Touch::slip_minus;
    set_mode(equations, touching[k], stop || modes[k] == Touch::stick ? Touch::stick : slides,
             state);
  }
  return true;
}

/// Where stops bounce while feet stay put the sum of Newton's and Coulomb's laws may add energy:
/// then nothing bounces.
void limit_rebound(ContactSystem& s, const Touch* modes) {
  double change = 0.0;  // of kinetic energy: lambda . (w + b)/2
  bool bounces = false;
  for (int k = 0; k < s.count; ++k) {
    bounces = bounces || s.target[k] > 0.0;
    for (int r = 2 * k; r < 2 * k + 2; ++r) change += 0.5 * s.lambda[r] * (s.w[r] + s.b[r]);
  }
  if (!bounces || change <= 0.0) return;

  std::fill(s.target, s.target + s.count, 0.0);
  Touch again[kMaxTouching] = {};
  std::copy(modes, modes + s.count, again);
  find_modes(s, again, nullptr, -1);
}

/// Rates after the impulses of Newton's and Coulomb's laws. `s`: of the rates before.
Outcome apply_impulses(PlantEquations& equations, const std::vector<int>& touching, ContactSystem s,
                       RunState& state) {
  s.scale_w = 1.0;
  s.scale_force = equations.force_scale() / 10.0;
  Touch modes[kMaxTouching] = {};
  for (int k = 0; k < s.count; ++k) {
    const Unilateral& u = equations.unilaterals()[touching[k]];
    if (u.stop() && state.crowded <= kTired && s.b[2 * k + 1] < -kRest)
      s.target[k] = -u.restitution * s.b[2 * k + 1];
    modes[k] = state.modes[touching[k]];
    if (modes[k] == Touch::open) modes[k] = Touch::stick;
  }

  if (!find_modes(s, modes, nullptr, -1)) return unresolved("no impulse agrees with Coulomb's law");
  limit_rebound(s, modes);
  equations.rows(state.y, touching)
      ->add_response(*equations.inertia(state.y), s.lambda, state.y.data() + equations.size());

  for (int k = 0; k < s.count; ++k) {
    const int i = touching[k];
    const bool leaves = s.w[2 * k + 1] > kStill;
    // it hit and bounces: a stop event
    if (leaves && s.lambda[2 * k + 1] > 0.0) set_mode(equations, i, Touch::stick, state);
    const Touch stays = modes[k] == Touch::open ? state.modes[i] : modes[k];
    set_mode(equations, i, leaves ? Touch::open : stays, state);
  }
  return {};
}

}  // namespace

Outcome resolve_impact(PlantEquations& equations, double tolerance, RunState& state) {
  const Fault fault = singular("the mass matrix is singular at an impact");
  const std::vector<ContactState>* contacts = equations.contacts(state.y);
  if (contacts == nullptr) return fault;
  const std::vector<int> touching = candidates(equations, *contacts, true, tolerance, state);
  if (touching.empty()) return {};
  if (count_of(touching) > kMaxTouching) return too_many();

  if (!close_gaps(equations, touching, state.y)) return fault;
  const ContactSystem before = *equations.rate_system(state.y, touching);
  if (!end_at_rest(equations, touching, before, state)) {
    if (Outcome failed = apply_impulses(equations, touching, before, state)) return failed;
  }
  return resolve_modes(equations, tolerance, {}, state);
}

}  // namespace jaculus::simulation::detail
