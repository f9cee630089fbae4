#include "simulation/contact/plant_equations.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace jaculus::simulation::detail {

namespace {

/// Copper's resistance rises by this share a kelvin.
constexpr double kCopper = 0.0039;

}  // namespace

PlantEquations::PlantEquations(const Plant& plant, const Controller& controller)
    : plant_(plant),
      mechanism_(plant),
      drive_(plant, controller.quantity),
      inputs_(plant, controller),
      passive_(plant),
      laws_(plant),
      ground_(plant),
      unilaterals_(unilaterals_of(plant)) {
  warm_ = plant.winding.heat != 0.0 || plant.winding.initial != 0.0;
  force_scale_ = std::max(1e-6, std::abs(mechanism_.weight()));
  for (const Unilateral& u : unilaterals_) points_ += u.stop() ? 0 : 1;
  compliant_ = ground_.present() && points_ > 0;

  const auto motors = plant.model.motors.size();
  at_.contacts.resize(unilaterals_.size());
  at_.lambda.assign(2 * unilaterals_.size(), 0.0);
  at_.soles.resize(points_);
  motor_position_.resize(motors);
  motor_velocity_.resize(motors);
}

int PlantEquations::bristles() const { return windings() + (warm_ ? count_of(drive_.motors) : 0); }

int PlantEquations::law_states() const { return bristles() + (compliant_ ? points_ : 0); }

int PlantEquations::states() const { return law_states() + laws_.states(); }

// What acts on it
// -------------------------------------------------------------------------------------------------

void PlantEquations::read_motors(const State& y) {
  for (int m = 0; m < count_of(motor_velocity_); ++m) {
    motor_position_[m] = motor_position(m, y);
    motor_velocity_[m] = motor_velocity(m, y);
  }
}

void PlantEquations::take_inputs(double t, const State& y) {
  read_motors(y);
  inputs_.update(t, motor_position_.data(), motor_velocity_.data());
}

void PlantEquations::hold(const std::vector<double>& torques) {
  std::vector<Command> commands;
  for (const double torque : torques) commands.push_back({true, torque});
  inputs_.hold(std::move(commands));
}

// What follows from a state
// -------------------------------------------------------------------------------------------------

/// Frames and contacts at y, unless they stand there.
bool PlantEquations::place(const State& y) {
  const auto count = 2 * size();
  const auto bytes = count * sizeof(double);
  if (!placed_.empty() && std::memcmp(placed_.data(), y.data(), bytes) == 0) return true;

  weighed_ = rowed_ = false;
  placed_.clear();
  const double *q = y.data(), *v = q + size();
  if (!mechanism_.set(q, v)) return false;
  for (std::size_t i = 0; i < unilaterals_.size(); ++i)
    set_contact(mechanism_, unilaterals_[i], plant_.ground.height, q, v, at_.contacts[i]);
  placed_.assign(q, q + count);
  return true;
}

bool PlantEquations::weigh(const State& y) {
  if (!place(y)) return false;
  if (weighed_) return true;
  weighed_ = inertia_.set(mechanism_);
  return weighed_;
}

bool PlantEquations::fill_rows(const State& y, const std::vector<int>& touching) {
  if (!weigh(y)) return false;
  if (rowed_ && rows_.touching() == touching) return true;
  rows_.set(inertia_, at_.contacts, touching);
  rowed_ = true;
  return true;
}

const std::vector<ContactState>* PlantEquations::contacts(const State& y) {
  return place(y) ? &at_.contacts : nullptr;
}

const Inertia* PlantEquations::inertia(const State& y) { return weigh(y) ? &inertia_ : nullptr; }

const ContactRows* PlantEquations::rows(const State& y, const std::vector<int>& touching) {
  return fill_rows(y, touching) ? &rows_ : nullptr;
}

void PlantEquations::fast_slopes(const State& y, std::vector<FastPart>& parts) {
  parts.clear();
  if (!(passive_.has_fast_parts() || laws_.has_fast_parts()) || !weigh(y)) return;
  const double *q = y.data(), *v = q + size();
  passive_.list_fast_parts(mechanism_, drive_.motors, q, v, parts);
  laws_.list_fast_parts(mechanism_, q, v, parts);
}

const FastParts& PlantEquations::fast_parts(const State& y, const std::vector<Touch>& modes) {
  fast_.size = size();
  fast_slopes(y, fast_.parts);
  if (fast_.parts.empty()) return fast_;
  list_touching(modes);
  if (!touching_.empty()) {
    fill_rows(y, touching_);
    rows_.set_system(unilaterals_, system_);
  }

  for (FastPart& part : fast_.parts) {
    part.response = part.row;
    inertia_.forward(part.response.data());
    if (!touching_.empty()) {
      std::fill(system_.b, system_.b + 2 * system_.count, 0.0);
      rows_.add_product(part.response.data(), system_.b);
      // Contacts that are singular stop evaluate() as well; here a slope is less exact.
      if (solve_forces(system_, touching_modes_.data()))
        rows_.add_transposed(system_.lambda, part.response.data());
    }
    inertia_.backward(part.response.data());
  }
  return fast_;
}

/// Motors by their commands at (t, y); the bus' voltage.
double PlantEquations::set_drive(double t, const State& y) {
  read_motors(y);
  const Command* commands = inputs_.commands(t, motor_position_.data(), motor_velocity_.data());
  return drive_.set(inputs_.quantity(), commands, motor_velocity_.data(),
                    warm_ ? &y[windings()] : nullptr);
}

/// force_ and free_, everything up to the acceleration without rigid contacts. Weighed at y.
void PlantEquations::set_forces(double t, const State& y, const std::vector<Touch>& modes) {
  const double *q = y.data(), *v = q + size();
  force_.fill(0.0);
  const double* own = y.data() + law_states();
  if (!laws_.empty()) take_changes(laws_.before_motors(mechanism_, inertia_, t, q, v, own));
  at_.bus = set_drive(t, y);

  for (std::size_t m = 0; m < motor_velocity_.size(); ++m) {
    const double torque = plant_.model.motors[m].count * drive_.motors[m].torque;
    for (const std::size_t i : mechanism_.motor_columns[m])
      force_[i] += torque * mechanism_.motor_row[m][i];
  }
  passive_.add(mechanism_, inertia_, drive_.motors, q, v, force_.data());
  if (!laws_.empty()) laws_.add(mechanism_, drive_.motors, at_.bus, q, v, force_.data());
  if (compliant_) add_ground(y, modes);
  for (const Push* push : inputs_.pushes()) add_push(*push, t, q, v);

  for (int i = 0; i < size(); ++i) free_[i] = balance_[i] = force_[i] - inertia_.bias(i);
  inertia_.forward(free_.data());
}

void PlantEquations::take_changes(const PlantChanges& changes) {
  drive_.change(changes);
  for (Unilateral& u : unilaterals_)
    if (!u.stop()) u.mu = plant_.ground.friction * changes.friction_scale;
}

void PlantEquations::add_push(const Push& push, double t, const double* q, const double* v) {
  const Frame& base = mechanism_.frame(0);
  const double share = push.share_at(t);
  for (int i = 0; i < size(); ++i)
    force_[i] += share * (push.force_W.x() * base.jx[i] + push.force_W.y() * base.jz[i] +
                          push.moment * base.w[i]);
  if (push.joint.empty()) return;

  const int motor = plant_.model.motor_index(push.joint);
  const int body = plant_.model.body_of_joint(push.joint);
  JointState joint;
  if (motor < 0) mechanism_.joint(body, q, v, joint);
  const Row& row = motor < 0 ? joint.row : mechanism_.motor_row[motor];
  const int count = motor < 0 ? plant_.model.bodies[body].count : plant_.model.motors[motor].count;
  for (int i = 0; i < size(); ++i) force_[i] += share * count * push.torque * row[i];
}

void PlantEquations::add_ground(const State& y, const std::vector<Touch>& modes) {
  const double* bristle = &y[bristles()];
  for (int i = 0; i < points_; ++i) {
    const ContactState& c = at_.contacts[i];
    const SoleState& sole = at_.soles[i] =
        ground_.sole(unilaterals_[i], c, modes[i] != Touch::open, bristle[i]);
    at_.lambda[2 * i] = sole.tangential;
    at_.lambda[2 * i + 1] = sole.normal;
    if (sole.normal == 0.0) continue;
    for (int k = 0; k < size(); ++k)
      force_[k] += sole.tangential * c.tangential[k] + sole.normal * c.normal[k];
  }
}

const double* PlantEquations::balance(double t, const State& y, const std::vector<Touch>& modes) {
  if (!weigh(y)) return nullptr;
  set_forces(t, y, modes);
  return balance_.data();
}

/// The system of the rows, w their accelerations by free_.
void PlantEquations::set_accelerations() {
  rows_.set_system(unilaterals_, system_);
  double free[kStride] = {};
  rows_.add_product(free_.data(), free);
  for (int k = 0; k < system_.count; ++k) {
    const ContactState& c = at_.contacts[rows_.touching()[k]];
    system_.b[2 * k] = free[2 * k] + c.tangential_bias;
    system_.b[2 * k + 1] = free[2 * k + 1] + c.normal_bias;
  }
}

const ContactSystem* PlantEquations::acceleration_system(double t, const State& y,
                                                         const std::vector<Touch>& modes,
                                                         const std::vector<int>& touching) {
  if (!fill_rows(y, touching)) return nullptr;
  set_forces(t, y, modes);
  set_accelerations();
  return &system_;
}

const ContactSystem* PlantEquations::rate_system(const State& y, const std::vector<int>& touching) {
  if (!fill_rows(y, touching)) return nullptr;
  rows_.set_system(unilaterals_, system_);
  const double* v = y.data() + size();
  for (int k = 0; k < system_.count; ++k) {
    const ContactState& c = at_.contacts[touching[k]];
    system_.b[2 * k] = dot(c.tangential, v, size());
    system_.b[2 * k + 1] = dot(c.normal, v, size());
  }
  return &system_;
}

// The right-hand side
// -------------------------------------------------------------------------------------------------

/// Rigid contacts that are closed, and their modes.
void PlantEquations::list_touching(const std::vector<Touch>& modes) {
  touching_.clear();
  touching_modes_.clear();
  for (int i = 0; i < count_of(modes); ++i) {
    if (compliant(i) || modes[i] == Touch::open) continue;
    touching_.push_back(i);
    touching_modes_.push_back(modes[i]);
  }
}

/// Forces of the rigid contacts that are closed, and what L^T a has of them.
bool PlantEquations::add_contacts(const State& y, const std::vector<Touch>& modes,
                                  double* acceleration) {
  list_touching(modes);
  for (int i = 0; i < count_of(modes); ++i)
    if (!compliant(i)) at_.lambda[2 * i] = at_.lambda[2 * i + 1] = 0.0;
  if (touching_.empty()) return true;

  fill_rows(y, touching_);
  set_accelerations();
  if (!solve_forces(system_, touching_modes_.data())) return false;
  for (std::size_t k = 0; k < touching_.size(); ++k) {
    at_.lambda[2 * touching_[k]] = system_.lambda[2 * k];
    at_.lambda[2 * touching_[k] + 1] = system_.lambda[2 * k + 1];
  }
  rows_.add_transposed(system_.lambda, acceleration);
  return true;
}

/// Rates of what is no coordinate: soles, states of laws, windings.
void PlantEquations::set_slow_rates(const State& y, State& dydt) const {
  if (compliant_)
    for (int i = 0; i < points_; ++i) dydt[bristles() + i] = at_.soles[i].bristle_rate;

  std::copy(laws_.rates().begin(), laws_.rates().end(), dydt.begin() + law_states());

  if (!warm_) return;
  for (int m = 0; m < count_of(drive_.motors); ++m) {
    const double temperature = y[windings() + m], i = drive_.motors[m].current;
    dydt[windings() + m] = plant_.winding.heat * i * i * plant_.model.motors[m].resistance *
                           (1.0 + kCopper * temperature);
  }
}

bool PlantEquations::sample_drive(double t, const State& y, DriveSample& out) {
  if (!laws_.empty()) return false;
  out.motors = drive_.motors;
  out.bus = set_drive(t, y);
  out.motors.swap(drive_.motors);
  return true;
}

const Evaluation* PlantEquations::evaluate(double t, const State& y,
                                           const std::vector<Touch>& modes, State& dydt) {
  ++evaluations_;
  if (!weigh(y)) return nullptr;
  set_forces(t, y, modes);

  double* acceleration = dydt.data() + size();
  for (int i = 0; i < size(); ++i) {
    dydt[i] = y[size() + i];
    acceleration[i] = free_[i];
  }
  if (!add_contacts(y, modes, acceleration)) return nullptr;
  inertia_.backward(acceleration);
  set_slow_rates(y, dydt);

  const bool finite = std::all_of(dydt.begin(), dydt.begin() + states(),
                                  [](double rate) { return std::isfinite(rate); });
  return finite ? &at_ : nullptr;
}

}  // namespace jaculus::simulation::detail
