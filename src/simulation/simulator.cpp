#include "simulation/simulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

#include "jaculus/core/error.h"

namespace jaculus::detail {

namespace {

constexpr double kDriftTime = 0.1;  ///< over which a rate of drift counts as a drift [s]

}  // namespace

Simulator::Simulator(const Plant& plant, const Controller& controller, const StartState& start,
                     const SimulationOptions& options)
    : options_(options), equations_(plant, controller) {
  const auto states = static_cast<size_t>(equations_.states());
  for (State* s : {&y_, &dydt_, &y_new_, &dydt_new_, &error_, &y_dense_, &dydt_dense_, &y_stage_, &k2_, &k3_, &k4_})
    s->assign(states, 0.0);
  if (start.q.size() != equations_.mechanism.n_model || start.v.size() != start.q.size())
    throw InputError(fmt::format("the start has {} coordinates and {} rates; the robot has {}", start.q.size(),
                                 start.v.size(), equations_.mechanism.n_model));
  const int n = equations_.n();
  for (int i = 0; i < equations_.mechanism.n_model; ++i) {
    y_[static_cast<size_t>(i)] = start.q[i];
    y_[static_cast<size_t>(n + i)] = start.v[i];
  }
  for (int i = 2 * n; i < equations_.bristles(); ++i) y_[static_cast<size_t>(i)] = plant.winding.initial;
  const auto samples = options.sample_times.size();
  const auto motors = static_cast<Eigen::Index>(plant.model.motors.size());
  out_.time = options.sample_times;
  out_.q.resize(start.q.size(), samples);
  out_.v.resize(start.q.size(), samples);
  for (Matrix* m : {&out_.motor_position, &out_.motor_velocity, &out_.torque, &out_.current, &out_.voltage})
    m->resize(motors, samples);
  out_.bus_voltage.resize(samples);
  out_.force.setZero(2 * static_cast<Eigen::Index>(plant.model.feet.size()), samples);
}

bool Simulator::fail(SimulationStatus status, const std::string& message) {
  out_.status = status;
  out_.message = fmt::format("at {:.6f} s: {}", t_, message);
  return false;
}

Simulation Simulator::run() {
  bool going = equations_.set_state(y_.data()) || fail(SimulationStatus::singular, "the start's loops can't be closed");
  if (going) going = enter(0.0);
  while (going && t_ < options_.duration) {
    const double change = equations_.next_change(t_);
    going = step(std::min(change, options_.duration));
    if (!going) break;
    if (options_.stop_at_lift_off && touched_ && !touching_anything()) break;
    if (t_ == change) going = enter(t_);
  }
  if (going) record_before(t_);
  if (going && sample_ < out_.time.size() && out_.time[sample_] <= t_) {
    equations_.evaluate(t_, y_.data(), dydt_.data());
    record(t_, y_);
  }
  out_.end_time = t_;
  out_.evaluations = equations_.evaluations;
  const Eigen::Index kept = sample_;
  out_.time.conservativeResize(kept);
  for (Matrix* m : {&out_.q, &out_.v, &out_.motor_position, &out_.motor_velocity, &out_.torque, &out_.current,
                    &out_.voltage, &out_.force})
    m->conservativeResize(Eigen::NoChange, kept);
  out_.bus_voltage.conservativeResize(kept);
  return std::move(out_);
}

/// Takes the jumps at t, brings the contacts into line with them and evaluates the start of the next step.
bool Simulator::enter(double t) {
  equations_.update(t, y_.data());
  if (t == 0.0 && (!sink() || !rest() || !impact())) return false;
  if (t == 0.0 && equations_.commander.waiting() && !stand()) return false;
  return evaluate_start();
}

/// Right-hand side at the start of a step; contacts that its forces contradict change their mode.
bool Simulator::evaluate_start() {
  for (int attempts = 0; attempts < 3; ++attempts) {
    if (!equations_.evaluate(t_, y_.data(), dydt_.data(), stands_))
      return fail(SimulationStatus::singular, "the equations of motion are singular");
    list_functions();
    bool sound = true;
    for (EventFunction& f : functions_) {
      f.at_start = f.at_end = value(f);
      if (f.kind == Function::gap) f.rate_at_start = equations_.contacts[static_cast<size_t>(f.contact)].normal_rate;
      sound = sound && (!forces_at(f) || f.at_start >= -f.tolerance);
    }
    if (sound) {
      while (sample_ < out_.time.size() && out_.time[sample_] <= t_) record(t_, y_);
      log_limits();
      return true;
    }
    stands_ = false;
    if (!settle(nullptr, -1)) return false;
  }
  return fail(SimulationStatus::contact_unresolved, "contacts find no mode that their forces agree with");
}

void Simulator::log_limits() {
  limited_.resize(equations_.drive.motors.size(), false);
  for (size_t m = 0; m < limited_.size(); ++m) {
    const bool now = equations_.drive.motors[m].limited;
    if (now && !limited_[m]) out_.events.push_back({t_, EventKind::limit, equations_.motor_name(m)});
    limited_[m] = now;
  }
}

void Simulator::list_functions() {
  functions_.clear();
  const double force = 1e-9 * equations_.force_scale;
  for (size_t i = 0; i < equations_.modes.size(); ++i) {
    const int c = static_cast<int>(i);
    const Touch mode = equations_.modes[i];
    if (mode == Touch::open) {
      functions_.push_back({Function::gap, c, 1e-3 * options_.contact_tolerance});
      continue;
    }
    if (equations_.compliant(i)) {
      functions_.push_back({Function::height, c, 1e-3 * options_.contact_tolerance});
      continue;
    }
    functions_.push_back({Function::lift, c, force});
    if (equations_.unilaterals[i].stop()) continue;
    if (mode == Touch::stick) {
      functions_.push_back({Function::cone_plus, c, force});
      functions_.push_back({Function::cone_minus, c, force});
    } else {
      functions_.push_back({Function::slide, c, 0.5 * kStill});
    }
  }
}

double Simulator::value(const EventFunction& f) const {
  const auto i = static_cast<size_t>(f.contact);
  const double normal = equations_.lambda[2 * i + 1], tangential = equations_.lambda[2 * i];
  switch (f.kind) {
    case Function::gap:
      return equations_.contacts[i].gap;
    case Function::height:
      return -equations_.contacts[i].gap;
    case Function::lift:
      return normal;
    case Function::cone_plus:
      return equations_.unilaterals[i].mu * normal - tangential;
    case Function::cone_minus:
      return equations_.unilaterals[i].mu * normal + tangential;
    case Function::slide:
      return slip_sign(equations_.modes[i]) * equations_.contacts[i].tangential_rate;
  }
  return 0.0;
}

double Simulator::value_at(const EventFunction& f, double t, double shift) {
  dense(t, y_dense_);
  const bool ok = forces_at(f) ? equations_.evaluate(t, y_dense_.data(), dydt_dense_.data())
                               : equations_.set_state(y_dense_.data());
  return ok ? value(f) + shift : -f.tolerance;
}

/// Whether a gap that is open at both ends of the step closes between them; `bottom`: an instant at which it is closed.
bool Simulator::dips(EventFunction& f, double& bottom) {
  const double rate = equations_.contacts[static_cast<size_t>(f.contact)].normal_rate;
  if (f.kind != Function::gap || !(f.rate_at_start < 0.0 && rate > 0.0)) return false;
  const double share = f.rate_at_start / (f.rate_at_start - rate);
  if (f.at_start + 0.75 * f.rate_at_start * share * step_ > 0.0) return false;
  bottom = t_ + share * step_;
  return true;
}

/// The instant within the step at which f passes zero, or has just passed its tolerance where it began below zero.
double Simulator::first_crossing(const EventFunction& f) {
  // Where it is clearly positive at the start, zero itself is looked for.
  const double shift = f.at_start > f.tolerance ? 0.0 : f.tolerance;
  double from = t_, at_from = f.at_start + shift;
  if (at_from <= 0.0) {
    // Just off a contact: the bracket begins where the gap has opened.
    for (double share = 1e-9; share < 0.9 && at_from <= 0.0 && f.kind == Function::gap; share *= 4.0) {
      from = t_ + share * (t_new_ - t_);
      at_from = value_at(f, from, shift);
    }
  }
  if (at_from <= 0.0 || f.at_end + shift > 0.0) return t_;
  std::uintmax_t iterations = 80;
  const auto close = [](double a, double b) { return b - a < 1e-12; };
  const auto root = boost::math::tools::toms748_solve([&](double t) { return value_at(f, t, shift); }, from, t_new_,
                                                      at_from, f.at_end + shift, close, iterations);
  return root.second;
}

bool Simulator::handle_events() {
  const EventFunction* first = nullptr;
  double at = t_new_;
  std::vector<std::pair<EventFunction*, double>> suspects;
  for (EventFunction& f : functions_) {
    f.at_end = value(f);
    double bottom = 0.0;
    if (f.at_end < -f.tolerance)
      suspects.emplace_back(&f, t_new_);
    else if (dips(f, bottom))
      suspects.emplace_back(&f, bottom);
  }
  const double t_end = t_new_;
  for (auto& [f, until] : suspects) {
    t_new_ = until;
    if (until != t_end) {
      f->at_end = value_at(*f, until, 0.0);
      if (f->at_end >= -f->tolerance) continue;
    }
    const double crossing = first_crossing(*f);
    if (first == nullptr || crossing < at) {
      first = f;
      at = crossing;
    }
  }
  t_new_ = at;
  if (first == nullptr) {
    if (!suspects.empty()) equations_.evaluate(t_new_, y_new_.data(), dydt_new_.data());
    label_soles();
    stands_ = !project();
    for (EventFunction& f : functions_) {
      f.at_start = f.at_end;
      if (f.kind == Function::gap) f.rate_at_start = equations_.contacts[static_cast<size_t>(f.contact)].normal_rate;
    }
    if (record_before(t_new_)) stands_ = false;
    t_ = t_new_;
    y_.swap(y_new_);
    dydt_.swap(dydt_new_);
    return true;
  }
  const EventFunction event = *first;
  record_before(at);
  dense(at, y_dense_);
  y_new_ = y_dense_;
  if (!equations_.evaluate(at, y_new_.data(), dydt_new_.data()))
    return fail(SimulationStatus::singular, "the equations of motion are singular at an event");
  project();
  t_ = at;
  y_.swap(y_new_);
  h_ = std::max(h_, 1e-4);
  return transition(event) && evaluate_start();
}

/// Takes drift off the closed contacts where it is more than a trace: the least change of positions and rates by the mass matrix'
/// measure. After evaluate() at y_new_. Whether there was a change.
bool Simulator::project() {
  std::vector<int> closed;
  Touch modes[kMaxTouching];
  for (size_t i = 0; i < equations_.modes.size(); ++i) {
    if (equations_.modes[i] == Touch::open || equations_.compliant(i)) continue;
    modes[closed.size()] = equations_.modes[i] == Touch::stick ? Touch::stick : Touch::slip_plus;
    closed.push_back(static_cast<int>(i));
  }
  double drift = 0.0;
  for (size_t k = 0; k < closed.size(); ++k) {
    const ContactState& c = equations_.contacts[static_cast<size_t>(closed[k])];
    drift = std::max({drift, std::abs(c.gap), kDriftTime * std::abs(c.normal_rate),
                      modes[k] == Touch::stick ? kDriftTime * std::abs(c.tangential_rate) : 0.0});
  }
  if (drift <= 1e-4 * options_.contact_tolerance) return false;
  ContactSystem& s = equations_.system;
  const int n = equations_.n();
  for (int rates = 0; rates < 2; ++rates) {
    for (size_t k = 0; k < closed.size(); ++k) {
      const ContactState& c = equations_.contacts[static_cast<size_t>(closed[k])];
      if (modes[k] != Touch::stick) s.mu[k] = 0.0;
      s.target[k] = 0.0;
      s.b[2 * k] = rates == 1 ? c.tangential_rate : 0.0;
      s.b[2 * k + 1] = rates == 1 ? c.normal_rate : c.gap;
    }
    if (solve_at(s, modes)) equations_.add_response(closed, s.lambda, y_new_.data() + (rates == 1 ? n : 0));
  }
  return true;
}

/// Samples before t, on the dense output. Whether there was any: the equations then stand elsewhere.
bool Simulator::record_before(double t) {
  const Eigen::Index before = sample_;
  while (sample_ < out_.time.size() && out_.time[sample_] < t) {
    const double at = out_.time[sample_];
    dense(at, y_dense_);
    equations_.evaluate(at, y_dense_.data(), dydt_dense_.data());
    record(at, y_dense_);
  }
  return sample_ > before;
}

/// The equations must stand at (t, y).
void Simulator::record(double, const State& y) {
  const Eigen::Index k = sample_++;
  const int n = equations_.n();
  for (Eigen::Index i = 0; i < out_.q.rows(); ++i) {
    out_.q(i, k) = y[static_cast<size_t>(i)];
    out_.v(i, k) = y[static_cast<size_t>(n + i)];
  }
  for (size_t m = 0; m < equations_.drive.motors.size(); ++m) {
    const auto row = static_cast<Eigen::Index>(m);
    const MotorState& motor = equations_.drive.motors[m];
    out_.motor_position(row, k) = equations_.motor_position[m];
    out_.motor_velocity(row, k) = equations_.motor_velocity[m];
    out_.torque(row, k) = motor.torque;
    out_.current(row, k) = motor.current;
    out_.voltage(row, k) = motor.voltage;
  }
  out_.bus_voltage[k] = equations_.bus;
  for (size_t i = 0; i < equations_.unilaterals.size(); ++i) {
    const int foot = equations_.unilaterals[i].foot;
    if (foot < 0) continue;
    out_.force(2 * foot, k) = equations_.lambda[2 * i];
    out_.force(2 * foot + 1, k) = equations_.lambda[2 * i + 1];
  }
}

}  // namespace jaculus::detail
