#include "simulation/plant_equations.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "jaculus/core/error.h"

namespace jaculus::detail {

namespace {

double dot(const Row& a, const double* b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[static_cast<size_t>(i)] * b[i];
  return sum;
}

}  // namespace

PlantEquations::PlantEquations(const Plant& plant, const Controller& controller)
    : mechanism(plant),
      drive(plant, controller.quantity),
      commander(plant, controller),
      plant_(plant),
      quantity_(controller.quantity) {
  const PlanarModel& model = plant.model;
  heat_ = plant.winding.heat;
  warm_ = heat_ != 0.0 || plant.winding.initial != 0.0;
  pushing_.assign(plant.pushes.size(), false);
  force_scale = std::max(1e-6, std::abs(mechanism.weight()));
  add_elements();
  add_unilaterals();
  motor_position.resize(model.motors.size());
  motor_velocity.resize(model.motors.size());
}

void PlantEquations::add_unilaterals() {
  const PlanarModel& model = plant_.model;
  const auto add_point = [&](const PlanarPoint& point, double radius, int foot) {
    Unilateral u;
    u.name = point.name;
    u.body = point.body;
    u.position = point.position;
    u.radius = radius;
    u.count = point.count;
    u.mu = plant_.ground.friction;
    u.foot = foot;
    unilaterals.push_back(u);
  };
  for (size_t f = 0; f < model.feet.size(); ++f)
    add_point(model.feet[f], plant_.ground.foot_radius, static_cast<int>(f));
  for (const std::string& name : plant_.ground_points) {
    const PlanarPoint* found = nullptr;
    for (const PlanarPoint& point : model.points)
      if (point.name == name) found = &point;
    if (found == nullptr) throw InputError(fmt::format("ground point: the robot has no point '{}'", name));
    add_point(*found, 0.0, -1);
  }
  for (const JointStop& stop : plant_.stops) {
    const int body = model.body_of_joint(stop.joint);
    if (body < 0) throw InputError(fmt::format("stop: the robot has no joint '{}'", stop.joint));
    for (double side : {1.0, -1.0}) {
      const double bound = side > 0.0 ? stop.range.lower : stop.range.upper;
      if (std::isinf(bound)) continue;
      Unilateral u;
      u.name = stop.joint;
      u.body = body;
      u.side = side;
      u.bound = bound;
      u.restitution = stop.restitution;
      unilaterals.push_back(u);
    }
  }
  points_ = 0;
  for (const Unilateral& u : unilaterals) points_ += u.stop() ? 0 : 1;
  compliant_ = plant_.ground.compliance > 0.0 && points_ > 0;
  int feet = 0;
  for (const PlanarPoint& foot : model.feet) feet += foot.count;
  mass_of_foot_ = model.total_mass() / std::max(1, feet);
  bristle_rate.assign(points_, 0.0);
  sole.assign(points_, Touch::stick);
  contacts.resize(unilaterals.size());
  modes.assign(unilaterals.size(), Touch::open);
  lambda.assign(2 * unilaterals.size(), 0.0);
}

void PlantEquations::set_contact(size_t i, const double* y) {
  const Unilateral& u = unilaterals[i];
  ContactState& c = contacts[i];
  if (u.stop()) {
    JointState joint;
    mechanism.joint(u.body, y, y + n(), joint);
    c.gap = u.side * (joint.value - u.bound);
    c.normal_rate = u.side * joint.rate;
    c.normal_bias = u.side * joint.bias;
    c.tangential_rate = c.tangential_bias = 0.0;
    for (size_t k = 0; k < static_cast<size_t>(n()); ++k) {
      c.normal[k] = u.side * joint.row[k];
      c.tangential[k] = 0.0;
    }
    return;
  }
  PointState point;
  mechanism.point(u.body, u.position, point);
  c.gap = point.pz - u.radius - plant_.ground.height;
  c.normal_rate = point.vz;
  c.tangential_rate = point.vx;
  c.normal_bias = point.az;
  c.tangential_bias = point.ax;
  c.normal = point.jz;
  c.tangential = point.jx;
  if (u.radius == 0.0) return;
  const Frame& f = mechanism.frame(u.body);
  c.tangential_rate -= u.radius * f.omega;
  c.tangential_bias -= u.radius * f.alpha;
  for (size_t k = 0; k < static_cast<size_t>(n()); ++k) c.tangential[k] -= u.radius * f.w[k];
}

bool PlantEquations::set_state(const double* y) {
  if (!mechanism.set(y, y + n())) return false;
  for (size_t i = 0; i < contacts.size(); ++i) set_contact(i, y);
  return true;
}

/// Cholesky of the mass matrix; h_ holds the bias.
bool PlantEquations::set_mass() {
  mechanism.assemble(L_, h_);
  const int size = n();
  for (int j = 0; j < size; ++j) {
    double* column = L_ + j * kMaxSize;
    for (int k = 0; k < j; ++k) {
      const double* other = L_ + k * kMaxSize;
      const double factor = other[j];
      for (int i = j; i < size; ++i) column[i] -= factor * other[i];
    }
    if (!(column[j] > 0.0)) return false;
    const double inverse = 1.0 / std::sqrt(column[j]);
    inverse_diagonal_[j] = inverse;
    for (int i = j; i < size; ++i) column[i] *= inverse;
  }
  return true;
}

void PlantEquations::forward(double* x) const {
  const int size = n();
  for (int j = 0; j < size; ++j) {
    const double* column = L_ + j * kMaxSize;
    const double value = x[j] *= inverse_diagonal_[j];
    for (int i = j + 1; i < size; ++i) x[i] -= column[i] * value;
  }
}

void PlantEquations::backward(double* x) const {
  const int size = n();
  for (int j = size - 1; j >= 0; --j) {
    const double* column = L_ + j * kMaxSize;
    double sum = x[j];
    for (int i = j + 1; i < size; ++i) sum -= column[i] * x[i];
    x[j] = sum * inverse_diagonal_[j];
  }
}

void PlantEquations::update(double t, const double* y) {
  read_motors(y);
  commander.update(t, motor_position.data(), motor_velocity.data());
  if (holding_ && !commander.waiting()) {
    holding_ = false;
    drive.take(quantity_);
  }
  for (size_t p = 0; p < pushing_.size(); ++p) {
    const Push& push = plant_.pushes[p];
    pushing_[p] = t >= push.start && t < push.start + push.duration;
  }
}

double PlantEquations::next_change(double t) const {
  double next = commander.next_change(t);
  for (const Push& push : plant_.pushes)
    for (double at : {push.start, push.start + push.duration})
      if (at > t) next = std::min(next, at);
  return next;
}

std::string PlantEquations::beyond_range(const double* y) const {
  const Coordinate* worst = nullptr;
  double furthest = 0.0, value = 0.0;
  for (size_t i = 0; i < plant_.model.coordinates.size(); ++i) {
    const Coordinate& c = plant_.model.coordinates[i];
    const double outside = std::max(c.range.lower - y[i], y[i] - c.range.upper);
    if (!(outside > furthest)) continue;
    worst = &c;
    furthest = outside;
    value = y[i];
  }
  if (worst == nullptr) return "";
  return fmt::format("; {} is at {:.4g}, beyond its range {:.4g} to {:.4g}, and no stop holds it there", worst->name,
                     value, worst->range.lower, worst->range.upper);
}

void PlantEquations::read_motors(const double* y) {
  for (size_t m = 0; m < motor_velocity.size(); ++m) {
    motor_position[m] = mechanism.motor_angle(static_cast<int>(m), y);
    motor_velocity[m] = mechanism.motor_rate(static_cast<int>(m), y + n());
  }
}

void PlantEquations::set_forces(double t, const double* y) {
  const int size = n();
  for (int i = 0; i < size; ++i) force_[i] = 0.0;
  read_motors(y);
  const Command* commands =
      holding_ ? hold_.data() : commander.commands(t, motor_position.data(), motor_velocity.data());
  bus = drive.set(commands, motor_velocity.data(), warm_ ? y + 2 * size : nullptr);
  for (size_t m = 0; m < motor_velocity.size(); ++m) {
    const double torque = plant_.model.motors[m].count * drive.motors[m].torque;
    for (size_t i = 0; i < static_cast<size_t>(size); ++i) force_[i] += torque * mechanism.motor_row[m][i];
  }
  if (!friction_.empty()) add_joint_friction();
  if (!springs_.empty()) add_hinges(y);
  add_drag();
  if (compliant_) add_ground(y);
  for (size_t p = 0; p < pushing_.size(); ++p) {
    if (!pushing_[p]) continue;
    const Push& push = plant_.pushes[p];
    const Frame& base = mechanism.frame(0);
    for (size_t i = 0; i < static_cast<size_t>(size); ++i)
      force_[i] += push.force_W.x() * base.jx[i] + push.force_W.y() * base.jz[i];
  }
  for (int i = 0; i < size; ++i) free_[i] = force_[i] - h_[i];
  forward(free_);
}

/// solved_ = L^-1 of what it holds, A = solved_^T solved_, of its first kRows columns side by side.
template <int kRows>
void PlantEquations::solve_rows() {
  const int size = n();
  double A[kRows * kRows] = {};
  for (int j = 0; j < size; ++j) {
    double* x = solved_ + j * kStride;
    const double* column = L_ + j * kMaxSize;
    for (int r = 0; r < kRows; ++r) x[r] *= inverse_diagonal_[j];
    for (int i = j + 1; i < size; ++i) {
      double* y = solved_ + i * kStride;
      for (int r = 0; r < kRows; ++r) y[r] -= column[i] * x[r];
    }
    for (int c = 0; c < kRows; ++c)
      for (int r = 0; r < kRows; ++r) A[c * kRows + r] += x[c] * x[r];
  }
  for (int c = 0; c < 2 * system.count; ++c)
    for (int r = 0; r < 2 * system.count; ++r) system.A[c * kStride + r] = A[c * kRows + r];
}

void PlantEquations::fill_rows(const std::vector<int>& touching) {
  const auto size = static_cast<size_t>(n());
  system.count = static_cast<int>(touching.size());
  const size_t rows = system.count <= 2 ? 4 : kStride;
  for (size_t j = 0; j < size; ++j) {
    double* x = solved_ + j * kStride;
    for (size_t k = 0; k < touching.size(); ++k) {
      const ContactState& c = contacts[static_cast<size_t>(touching[k])];
      x[2 * k] = c.tangential[j];
      x[2 * k + 1] = c.normal[j];
    }
    for (size_t r = 2 * touching.size(); r < rows; ++r) x[r] = 0.0;
  }
  if (rows == 4)
    solve_rows<4>();
  else
    solve_rows<kStride>();
}

void PlantEquations::fill_system(const std::vector<int>& touching, bool impact, const double* v) {
  const int size = n();
  double free[kStride] = {};  // accelerations of the rows without contact, the bias aside
  if (!impact)
    for (int j = 0; j < size; ++j)
      for (int r = 0; r < 2 * system.count; ++r) free[r] += solved_[j * kStride + r] * free_[j];
  for (size_t k = 0; k < touching.size(); ++k) {
    const auto i = static_cast<size_t>(touching[k]);
    const ContactState& c = contacts[i];
    system.mu[k] = unilaterals[i].mu;
    system.target[k] = 0.0;
    system.moving[k] = false;
    system.direction[k] = 0.0;
    system.b[2 * k] = impact ? dot(c.tangential, v, size) : free[2 * k] + c.tangential_bias;
    system.b[2 * k + 1] = impact ? dot(c.normal, v, size) : free[2 * k + 1] + c.normal_bias;
  }
}

void PlantEquations::add_response(const std::vector<int>& touching, const double* forces, double* x) const {
  double sum[kMaxSize] = {};
  for (size_t k = 0; k < touching.size(); ++k)
    for (size_t i = 0; i < static_cast<size_t>(n()); ++i)
      sum[i] += forces[2 * k] * solved_[i * kStride + 2 * k] + forces[2 * k + 1] * solved_[i * kStride + 2 * k + 1];
  backward(sum);
  for (int i = 0; i < n(); ++i) x[i] += sum[i];
}

bool PlantEquations::evaluate(double t, const double* y, double* dydt, bool stands) {
  ++evaluations;
  const int size = n();
  if (!stands && (!set_state(y) || !set_mass())) return false;
  set_forces(t, y);
  touching_.clear();
  touching_modes_.clear();
  for (size_t i = 0; i < modes.size(); ++i) {
    if (compliant(i)) continue;
    lambda[2 * i] = lambda[2 * i + 1] = 0.0;
    if (modes[i] == Touch::open) continue;
    touching_.push_back(static_cast<int>(i));
    touching_modes_.push_back(modes[i]);
  }
  for (int i = 0; i < size; ++i) {
    dydt[i] = y[size + i];
    dydt[size + i] = free_[i];
  }
  if (!touching_.empty()) {
    if (!stands) fill_rows(touching_);
    fill_system(touching_, false, y + size);
    if (!solve_forces(system, touching_modes_.data())) return false;
    for (size_t k = 0; k < touching_.size(); ++k) {
      const auto i = static_cast<size_t>(touching_[k]);
      lambda[2 * i] = system.lambda[2 * k];
      lambda[2 * i + 1] = system.lambda[2 * k + 1];
      const double* x = solved_ + 2 * k;
      for (int j = 0; j < size; ++j)
        dydt[size + j] += lambda[2 * i] * x[j * kStride] + lambda[2 * i + 1] * x[j * kStride + 1];
    }
  }
  backward(dydt + size);
  if (compliant_) {
    double* rate = dydt + bristles();
    for (size_t i = 0; i < points_; ++i) rate[i] = bristle_rate[i];
  }
  if (warm_) {
    for (size_t m = 0; m < drive.motors.size(); ++m) {
      const double temperature = y[2 * size + static_cast<int>(m)], i = drive.motors[m].current;
      dydt[2 * size + static_cast<int>(m)] =
          heat_ * i * i * plant_.model.motors[m].resistance * (1.0 + 0.0039 * temperature);
    }
  }
  for (int i = 0; i < states(); ++i)
    if (!std::isfinite(dydt[i])) return false;
  return true;
}

}  // namespace jaculus::detail
