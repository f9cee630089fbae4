#include "simulation/plant_equations.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "jaculus/components/tail_drag.h"
#include "jaculus/core/error.h"

namespace jaculus::detail {

namespace {

double dot(const Row& a, const double* b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[static_cast<size_t>(i)] * b[i];
  return sum;
}

/// Torque at which a flank of a gear gives way by its play: stiffness of the flanks = this / play [N m].
constexpr double kFlankTorque = 10.0;

}  // namespace

PlantEquations::PlantEquations(const Plant& plant, const Controller& controller)
    : mechanism(plant), drive(plant, controller.quantity), commander(plant, controller), plant_(plant) {
  const PlanarModel& model = plant.model;
  heat_ = plant.winding.heat;
  warm_ = heat_ != 0.0 || plant.winding.initial != 0.0;
  pushing_.assign(plant.pushes.size(), false);
  force_scale = std::max(1e-6, std::abs(mechanism.weight()));
  for (const JointFriction& f : plant.friction) {
    const int body = model.body_of_joint(f.joint);
    if (body < 0) throw InputError(fmt::format("friction: the robot has no joint '{}'", f.joint));
    const int motor = model.motor_index(f.joint);
    const PlanarBody& link = model.bodies[static_cast<size_t>(body)];
    if (f.coulomb == 0.0 && f.viscous == 0.0 && f.stribeck == 0.0 && f.load == 0.0) continue;
    friction_.push_back({&f, body, motor, motor < 0 ? link.count : model.motors[static_cast<size_t>(motor)].count});
  }
  for (const Transmission& t : plant.transmissions) {
    if (t.compliance == 0.0 && t.play == 0.0) continue;
    const int count = model.motors[static_cast<size_t>(model.motor_index(t.joint))].count;
    springs_.push_back({count / (t.compliance + t.play / kFlankTorque), t.damping_ratio, 0.5 * t.play, 0.1 * t.play});
  }
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

void PlantEquations::add_drag() {
  for (const PlanarDrag& drag : plant_.model.drags) {
    if (drag.kind == DragKind::none || drag.coefficient == 0.0) continue;
    const Frame& f = mechanism.frame(drag.body);
    const Vec2& d = drag.direction;
    const double nx = -f.s * d.x() + f.c * d.y(), nz = -f.c * d.x() - f.s * d.y();
    const double s = nx * (f.vx - drag.wind_W.x()) + nz * (f.vz - drag.wind_W.y());
    const DragLoad load = drag_load(drag, s, f.omega, plant_.drag_smoothing);
    for (size_t i = 0; i < static_cast<size_t>(n()); ++i)
      force_[i] += load.force * (nx * f.jx[i] + nz * f.jz[i]) + load.moment * f.w[i];
  }
}

void PlantEquations::add_joint_friction() {
  for (const Friction& f : friction_) {
    const JointFriction& d = *f.data;
    double rate, load = 0.0;
    JointState joint;
    const Row* row = &joint.row;
    if (f.motor >= 0) {
      rate = motor_velocity[static_cast<size_t>(f.motor)];
      row = &mechanism.motor_row[static_cast<size_t>(f.motor)];
      load = d.load * std::abs(drive.motors[static_cast<size_t>(f.motor)].torque);
    } else {
      mechanism.joint(f.body, force_, force_, joint);  // the row alone is of use
      const Frame &link = mechanism.frame(f.body),
                  &parent = mechanism.frame(plant_.model.bodies[static_cast<size_t>(f.body)].parent);
      rate = plant_.model.bodies[static_cast<size_t>(f.body)].sign * (link.omega - parent.omega);
    }
    const double ratio = rate / d.stribeck_rate;
    const double level = d.coulomb + load + (d.stribeck == 0.0 ? 0.0 : d.stribeck * std::exp(-ratio * ratio));
    const double torque = -f.count * (std::tanh(rate / d.smoothing_rate) * level + d.viscous * rate);
    for (size_t i = 0; i < static_cast<size_t>(n()); ++i) force_[i] += torque * (*row)[i];
  }
}

void PlantEquations::add_hinges(const double* y) {
  for (size_t k = 0; k < springs_.size(); ++k) {
    Spring& spring = springs_[k];
    const int i = mechanism.hinges[k].coordinate;
    if (spring.damping < 0.0) {
      double inertia = 0.0;  // M_ii from its factor
      for (int j = 0; j <= i; ++j) inertia += L_[j * kMaxSize + i] * L_[j * kMaxSize + i];
      spring.damping = 2.0 * spring.damping_ratio * std::sqrt(spring.stiffness * inertia);
    }
    const double angle = y[i], rate = y[n() + i], b = spring.half_play, s2 = spring.smoothing * spring.smoothing;
    double beyond = angle, slope = 1.0;
    if (b > 0.0) {
      const double up = std::sqrt((angle - b) * (angle - b) + s2), down = std::sqrt((angle + b) * (angle + b) + s2);
      beyond += 0.5 * (up - down);
      slope += 0.5 * ((angle - b) / up - (angle + b) / down);
    }
    force_[i] -= spring.stiffness * beyond + spring.damping * slope * rate;
  }
}

void PlantEquations::update(double t, const double* y) {
  read_motors(y);
  commander.update(t, motor_position.data(), motor_velocity.data());
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

void PlantEquations::read_motors(const double* y) {
  for (size_t m = 0; m < motor_velocity.size(); ++m) {
    motor_position[m] = mechanism.motor_angle(static_cast<int>(m), y);
    motor_velocity[m] = mechanism.motor_rate(static_cast<int>(m), y + n());
  }
}

bool PlantEquations::set_forces(double t, const double* y) {
  if (!set_mass()) return false;
  const int size = n();
  for (int i = 0; i < size; ++i) force_[i] = 0.0;
  read_motors(y);
  const Command* commands = commander.commands(t, motor_position.data(), motor_velocity.data());
  bus = drive.set(commands, motor_velocity.data(), warm_ ? y + 2 * size : nullptr);
  for (size_t m = 0; m < motor_velocity.size(); ++m) {
    const double torque = plant_.model.motors[m].count * drive.motors[m].torque;
    for (size_t i = 0; i < static_cast<size_t>(size); ++i) force_[i] += torque * mechanism.motor_row[m][i];
  }
  if (!friction_.empty()) add_joint_friction();
  if (!springs_.empty()) add_hinges(y);
  add_drag();
  for (size_t p = 0; p < pushing_.size(); ++p) {
    if (!pushing_[p]) continue;
    const Push& push = plant_.pushes[p];
    const Frame& base = mechanism.frame(0);
    for (size_t i = 0; i < static_cast<size_t>(size); ++i)
      force_[i] += push.force_W.x() * base.jx[i] + push.force_W.y() * base.jz[i];
  }
  for (int i = 0; i < size; ++i) free_[i] = force_[i] - h_[i];
  forward(free_);
  return true;
}

void PlantEquations::fill_rows(const std::vector<int>& touching) {
  const int size = n();
  system.count = static_cast<int>(touching.size());
  for (int i : touching) {
    ContactState& c = contacts[static_cast<size_t>(i)];
    c.solved_normal = c.normal;
    forward(c.solved_normal.data());
    c.solved_tangential = c.tangential;
    if (!unilaterals[static_cast<size_t>(i)].stop()) forward(c.solved_tangential.data());
  }
  const auto row = [&](int r) -> const Row& {
    const ContactState& c = contacts[static_cast<size_t>(touching[static_cast<size_t>(r / 2)])];
    return r % 2 == 0 ? c.solved_tangential : c.solved_normal;
  };
  for (int j = 0; j < 2 * system.count; ++j)
    for (int i = j; i < 2 * system.count; ++i)
      system.A[j * kStride + i] = system.A[i * kStride + j] = dot(row(i), row(j).data(), size);
}

void PlantEquations::fill_system(const std::vector<int>& touching, bool impact, const double* v) {
  fill_rows(touching);
  const int size = n();
  for (size_t k = 0; k < touching.size(); ++k) {
    const auto i = static_cast<size_t>(touching[k]);
    const ContactState& c = contacts[i];
    system.mu[k] = unilaterals[i].mu;
    system.target[k] = 0.0;
    system.moving[k] = false;
    system.direction[k] = 0.0;
    if (impact) {
      system.b[2 * k] = dot(c.tangential, v, size);
      system.b[2 * k + 1] = dot(c.normal, v, size);
    } else {
      system.b[2 * k] = dot(c.solved_tangential, free_, size) + c.tangential_bias;
      system.b[2 * k + 1] = dot(c.solved_normal, free_, size) + c.normal_bias;
    }
  }
}

void PlantEquations::add_response(const std::vector<int>& touching, const double* forces, double* x) const {
  double sum[kMaxSize] = {};
  for (size_t k = 0; k < touching.size(); ++k) {
    const ContactState& c = contacts[static_cast<size_t>(touching[k])];
    for (size_t i = 0; i < static_cast<size_t>(n()); ++i)
      sum[i] += forces[2 * k] * c.solved_tangential[i] + forces[2 * k + 1] * c.solved_normal[i];
  }
  backward(sum);
  for (int i = 0; i < n(); ++i) x[i] += sum[i];
}

bool PlantEquations::evaluate(double t, const double* y, double* dydt) {
  ++evaluations;
  const int size = n();
  if (!set_state(y) || !set_forces(t, y)) return false;
  touching_.clear();
  touching_modes_.clear();
  for (size_t i = 0; i < modes.size(); ++i) {
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
    fill_system(touching_, false, y + size);
    if (!solve_at(system, touching_modes_.data())) return false;
    for (size_t k = 0; k < touching_.size(); ++k) {
      const auto i = static_cast<size_t>(touching_[k]);
      lambda[2 * i] = system.lambda[2 * k];
      lambda[2 * i + 1] = system.lambda[2 * k + 1];
      const ContactState& c = contacts[i];
      for (int j = 0; j < size; ++j) {
        const auto s = static_cast<size_t>(j);
        dydt[size + j] += lambda[2 * i] * c.solved_tangential[s] + lambda[2 * i + 1] * c.solved_normal[s];
      }
    }
  }
  backward(dydt + size);
  if (warm_) {
    for (size_t m = 0; m < drive.motors.size(); ++m) {
      const double temperature = y[2 * size + static_cast<int>(m)], i = drive.motors[m].current;
      dydt[2 * size + static_cast<int>(m)] =
          heat_ * i * i * plant_.model.motors[m].resistance * (1.0 + 0.0039 * temperature);
    }
  }
  for (int i = 0; i < 2 * size; ++i)
    if (!std::isfinite(dydt[i])) return false;
  return true;
}

}  // namespace jaculus::detail
