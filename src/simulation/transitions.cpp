// What happens to contacts at an event: impacts, and the change of modes where forces ask for it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulation/simulator.h"

namespace jaculus::detail {

namespace {

constexpr double kRest = 1e-3;       ///< slower impacts end at rest: nothing bounces, nothing rocks on [m/s, rad/s]
constexpr int kCrowd = 60;           ///< events within kCrowdTime that make a cluster
constexpr double kCrowdTime = 1e-7;  ///< [s]
constexpr int kTired = 8;            ///< so many impacts within kCrowdTime of each other end at rest together

}  // namespace

bool Simulator::touching_anything() const {
  for (size_t i = 0; i < equations_.modes.size(); ++i)
    if (equations_.modes[i] != Touch::open && !equations_.unilaterals[i].stop()) return true;
  return false;
}

void Simulator::log(EventKind kind, int contact) {
  out_.events.push_back({t_, kind, equations_.unilaterals[static_cast<size_t>(contact)].name});
}

void Simulator::set_mode(int contact, Touch mode) {
  const auto i = static_cast<size_t>(contact);
  const Touch before = equations_.modes[i];
  if (before == mode) return;
  const bool stop = equations_.unilaterals[i].stop();
  if (!stop && mode != Touch::open) touched_ = true;
  equations_.modes[i] = mode;
  if (mode == Touch::open) {
    log(stop ? EventKind::release : EventKind::lift, contact);
  } else if (before == Touch::open) {
    log(stop ? EventKind::stop : EventKind::land, contact);
  } else {
    log(mode == Touch::stick ? EventKind::stick : EventKind::slip, contact);
  }
}

/// Contacts that take part in an impact (`approaching`: those that close at a rate too) or a change of modes.
std::vector<int> Simulator::candidates(bool approaching) const {
  std::vector<int> list;
  for (size_t i = 0; i < equations_.modes.size(); ++i) {
    if (equations_.compliant(i)) continue;
    const ContactState& c = equations_.contacts[i];
    const bool near = c.gap <= options_.contact_tolerance &&
                      (approaching ? c.normal_rate <= kStill || crowded_ > kTired : std::abs(c.normal_rate) <= kStill);
    if (equations_.modes[i] != Touch::open || near) list.push_back(static_cast<int>(i));
  }
  return list;
}

bool Simulator::transition(const EventFunction& f) {
  if (++transitions_ > options_.max_events)
    return fail(SimulationStatus::event_cluster, fmt::format("more than {} contact events", options_.max_events));
  crowded_ = t_ - last_event_ < kCrowdTime ? crowded_ + 1 : 0;
  last_event_ = t_;
  if (crowded_ > kCrowd)
    return fail(SimulationStatus::event_cluster,
                fmt::format("contact events of '{}' follow one another without end",
                            equations_.unilaterals[static_cast<size_t>(f.contact)].name));
  stands_ = false;
  equations_.set_state(y_.data());
  if (equations_.compliant(static_cast<size_t>(f.contact))) {
    compliant_transition(f);
    return true;
  }
  if (f.kind == Function::gap) return equations_.set_mass() && impact();
  const Touch before = equations_.modes[static_cast<size_t>(f.contact)];
  return settle(&before, f.contact);
}

/// Points that stand in compliant ground at the start are in contact.
bool Simulator::sink() {
  for (size_t i = 0; i < equations_.modes.size(); ++i) {
    if (!equations_.compliant(i) && equations_.contacts[i].gap < -options_.contact_tolerance)
      return fail(SimulationStatus::contact_unresolved,
                  fmt::format("'{}' starts {:.3g} beyond its contact", equations_.unilaterals[i].name,
                              -equations_.contacts[i].gap));
    if (equations_.compliant(i) && equations_.contacts[i].gap <= 0.0) set_mode(static_cast<int>(i), Touch::stick);
  }
  return true;
}

/// What nothing holds finds its place before time zero.
bool Simulator::rest() {
  if (!equations_.rest(0.0, y_.data()))
    return fail(SimulationStatus::singular, "hinges or a compliant floor find no equilibrium to start from");
  equations_.set_state(y_.data());
  if (!equations_.set_mass()) return fail(SimulationStatus::singular, "the mass matrix is singular");
  return true;
}

/// Holds the start's pose, with everything that touches sticking; whether it does so is for the forces to say.
bool Simulator::stand() {
  for (const int i : candidates(false)) equations_.modes[static_cast<size_t>(i)] = Touch::stick;
  if (!equations_.hold(0.0, y_.data())) return fail(SimulationStatus::singular, "the equations of motion are singular");
  return settle(nullptr, -1);
}

/// No impulse where the ground gives way.
void Simulator::compliant_transition(const EventFunction& f) {
  set_mode(f.contact, f.kind == Function::gap ? Touch::stick : Touch::open);
}

/// Whether soles on compliant ground stick or slip, for the list of events. After evaluate().
void Simulator::label_soles() {
  for (size_t i = 0; i < equations_.modes.size(); ++i)
    if (equations_.compliant(i) && equations_.modes[i] != Touch::open)
      set_mode(static_cast<int>(i), equations_.sole[i]);
}

/// Modes by the forces at (t_, y_): stick, slip or open for everything that touches.
bool Simulator::settle(const Touch* excluded, int excluded_contact) {
  stands_ = false;
  if (!equations_.set_state(y_.data()) || !equations_.set_mass())
    return fail(SimulationStatus::singular, "the equations of motion are singular");
  equations_.set_forces(t_, y_.data());
  const std::vector<int> touching = candidates(false);
  if (static_cast<int>(touching.size()) > kMaxTouching)
    return fail(SimulationStatus::contact_unresolved, fmt::format("more than {} contacts at a time", kMaxTouching));
  ContactSystem& s = equations_.system;
  equations_.fill_rows(touching);
  equations_.fill_system(touching, false, nullptr);
  s.scale_force = equations_.force_scale;
  s.scale_w = 10.0;
  Touch modes[kMaxTouching];
  int barred = -1;
  for (size_t k = 0; k < touching.size(); ++k) {
    const auto i = static_cast<size_t>(touching[k]);
    const double rate = equations_.contacts[i].tangential_rate;
    modes[k] = equations_.modes[i];
    s.moving[k] = s.mu[k] >= 0.0 && modes[k] != Touch::stick && std::abs(rate) > kStill;
    s.direction[k] = rate > 0.0 ? 1.0 : -1.0;
    if (s.moving[k] && modes[k] != Touch::open) modes[k] = rate > 0.0 ? Touch::slip_plus : Touch::slip_minus;
    if (touching[k] == excluded_contact) barred = static_cast<int>(k);
  }
  if (!find_modes(s, modes, barred < 0 ? nullptr : excluded, barred))
    return fail(SimulationStatus::contact_unresolved, "no mode of the contacts agrees with Coulomb's law (jamming)");
  for (size_t k = 0; k < touching.size(); ++k) set_mode(touching[k], modes[k]);
  return true;
}

/// Where stops bounce while feet stay put the sum of Newton's and Coulomb's laws may add energy: then nothing bounces.
void Simulator::limit_rebound(const std::vector<int>& touching, const Touch* modes) {
  ContactSystem& s = equations_.system;
  double change = 0.0;  // of kinetic energy: lambda . (w + b)/2
  bool bounces = false;
  for (size_t k = 0; k < touching.size(); ++k) {
    bounces = bounces || s.target[k] > 0.0;
    for (size_t r = 2 * k; r < 2 * k + 2; ++r) change += 0.5 * s.lambda[r] * (s.w[r] + s.b[r]);
  }
  if (!bounces || change <= 0.0) return;
  std::fill(s.target, s.target + s.count, 0.0);
  Touch again[kMaxTouching];
  std::copy(modes, modes + s.count, again);
  find_modes(s, again, nullptr, -1);
}

/// Impacts of a rocking body follow one another ever faster, without end. Slow ones end it: all that touch stay closed, which is the
/// projection of the rates on those that do so, hence takes energy; the forces then say which of them open.
bool Simulator::come_to_rest(const std::vector<int>& touching) {
  ContactSystem& s = equations_.system;
  Touch modes[kMaxTouching];
  for (size_t k = 0; k < touching.size(); ++k) {
    if (s.b[2 * k + 1] < -kRest || s.b[2 * k + 1] > kRest) return false;
    const bool sticks = std::abs(s.b[2 * k]) < kRest && s.mu[k] > 0.0;
    modes[k] = sticks ? Touch::stick : Touch::slip_plus;
    if (!sticks) s.mu[k] = 0.0;
  }
  if (!solve_at(s, modes)) return false;
  equations_.add_response(touching, s.lambda, y_.data() + equations_.n());
  for (size_t k = 0; k < touching.size(); ++k) {
    const bool stop = equations_.unilaterals[static_cast<size_t>(touching[k])].stop();
    const Touch slides = s.b[2 * k] > 0.0 ? Touch::slip_plus : Touch::slip_minus;
    set_mode(touching[k], stop || modes[k] == Touch::stick ? Touch::stick : slides);
  }
  return true;
}

/// Moves the robot by the trace that it is beyond contacts, so that none of them starts the next step below zero.
bool Simulator::close_gaps(const std::vector<int>& touching) {
  ContactSystem& s = equations_.system;
  Touch modes[kMaxTouching];
  equations_.fill_rows(touching);
  for (size_t k = 0; k < touching.size(); ++k) {
    modes[k] = Touch::slip_plus;
    s.mu[k] = s.target[k] = s.b[2 * k] = 0.0;
    s.b[2 * k + 1] = equations_.contacts[static_cast<size_t>(touching[k])].gap;
  }
  if (solve_at(s, modes)) equations_.add_response(touching, s.lambda, y_.data());
  return equations_.set_state(y_.data()) && equations_.set_mass();
}

/// Rates jump where touching contacts approach. After set_state and set_mass at y_.
bool Simulator::impact() {
  const std::vector<int> touching = candidates(true);
  if (touching.empty()) return true;
  if (static_cast<int>(touching.size()) > kMaxTouching)
    return fail(SimulationStatus::contact_unresolved, fmt::format("more than {} contacts at a time", kMaxTouching));
  if (!close_gaps(touching)) return fail(SimulationStatus::singular, "the mass matrix is singular at an impact");
  double* v = y_.data() + equations_.n();
  ContactSystem& s = equations_.system;
  equations_.fill_rows(touching);
  equations_.fill_system(touching, true, v);
  if (come_to_rest(touching)) return settle(nullptr, -1);
  equations_.fill_system(touching, true, v);
  s.scale_w = 1.0;
  s.scale_force = equations_.force_scale / 10.0;
  Touch modes[kMaxTouching];
  for (size_t k = 0; k < touching.size(); ++k) {
    const Unilateral& u = equations_.unilaterals[static_cast<size_t>(touching[k])];
    if (u.stop() && crowded_ <= kTired && s.b[2 * k + 1] < -kRest) s.target[k] = -u.restitution * s.b[2 * k + 1];
    modes[k] = equations_.modes[static_cast<size_t>(touching[k])];
    if (modes[k] == Touch::open) modes[k] = Touch::stick;
  }
  if (!find_modes(s, modes, nullptr, -1))
    return fail(SimulationStatus::contact_unresolved, "no impulse agrees with Coulomb's law");
  limit_rebound(touching, modes);
  equations_.add_response(touching, s.lambda, v);
  for (size_t k = 0; k < touching.size(); ++k) {
    const bool leaves = s.w[2 * k + 1] > kStill;
    if (leaves && s.lambda[2 * k + 1] > 0.0) set_mode(touching[k], Touch::stick);  // it hit and bounces: a stop event
    set_mode(touching[k], leaves                    ? Touch::open
                          : modes[k] == Touch::open ? equations_.modes[static_cast<size_t>(touching[k])]
                                                    : modes[k]);
  }
  return settle(nullptr, -1);
}

}  // namespace jaculus::detail
