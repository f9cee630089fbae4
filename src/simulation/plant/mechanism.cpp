#include "simulation/plant/mechanism.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "jaculus/core/error.h"

namespace jaculus::simulation::detail {

namespace {

Row to_row(const Eigen::Ref<const Eigen::RowVectorXd>& values) {
  Row row{};
  for (Eigen::Index i = 0; i < values.size(); ++i) row[i] = values[i];
  return row;
}

/// Of the values that are not zero.
Columns columns_of(const Row& row) {
  Columns columns;
  for (std::size_t i = 0; i < row.size(); ++i)
    if (row[i] != 0.0) columns.index[columns.count++] = i;
  return columns;
}

/// Position, velocity and acceleration of the point at r in a frame; gives the arm in the world.
template <class State>
Vec2 carry(const Frame& f, const Vec2& r, State& out) {
  const double ex = f.c * r.x() + f.s * r.y(), ez = -f.s * r.x() + f.c * r.y();
  const double square = f.omega * f.omega;
  out.px = f.px + ex;
  out.pz = f.pz + ez;
  out.vx = f.vx + ez * f.omega;
  out.vz = f.vz - ex * f.omega;
  out.ax = f.ax + ez * f.alpha - ex * square;
  out.az = f.az - ex * f.alpha - ez * square;
  return {ex, ez};
}

}  // namespace

Mechanism::Mechanism(const Plant& plant) {
  const model::PlanarModel& model = plant.model;
  n = n_model = model.size();
  if (n > kMaxSize)
    throw InputError(
        fmt::format("{} generalised coordinates: a plant may have {} at most", n, kMaxSize));
  for (int b = 0; b < count_of(model.bodies); ++b) {
    const model::PlanarBody& link = model.bodies[b];
    bodies_.push_back({link.parent, link.kind == model::JointKind::prismatic, false, link.origin,
                       link.axis, link.com, link.angle_offset, std::cos(link.angle_offset),
                       std::sin(link.angle_offset), link.sign, link.mass, link.inertia,
                       model.joint_offset[b], to_row(model.joint_map.row(b))});
    total_mass_ += link.mass;
  }

  for (int b : model.dependent) bodies_[b].dependent = true;
  frames_.resize(bodies_.size());
  loops_ = model.loops;
  int column = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (model.base_free[i]) base_[i] = column++;
  base_pose_ = model.base_pose;
  gravity_ = model.gravity;
  gravity_x_ = -gravity_ * std::sin(plant.gravity_tilt);
  gravity_z_ = gravity_ * std::cos(plant.gravity_tilt);

  for (const model::PlanarMotor& motor : model.motors) {
    const Body& link = bodies_[motor.body];
    motor_row.push_back(link.map);
    motor_columns.push_back(columns_of(link.map));
    motor_offset_.push_back(link.joint_offset);
  }

  add_transmissions(plant);
  for (Body& body : bodies_) body.columns = columns_of(body.map);
  add_step_order(model);
  find_columns();
  armature_.assign(kMaxSize * kMaxSize, 0.0);
  for (std::size_t m = 0; m < model.motors.size(); ++m) {
    const model::PlanarMotor& motor = model.motors[m];
    const double inertia = motor.count * motor.gear * motor.gear * motor.rotor_inertia;
    for (std::size_t j = 0; j < kMaxSize; ++j)
      for (std::size_t i = 0; i < kMaxSize; ++i)
        armature_[j * kMaxSize + i] += inertia * motor_row[m][i] * motor_row[m][j];
  }
}

/// Coordinates that move each body, the base's x and z aside; in rising order.
void Mechanism::find_columns() {
  std::vector<std::array<bool, kMaxSize>> moves(bodies_.size());
  const auto join = [&](std::size_t b, std::size_t other) {
    for (std::size_t i = 0; i < kMaxSize; ++i) moves[b][i] = moves[b][i] || moves[other][i];
  };

  if (base_[2] >= 0) moves[0][base_[2]] = true;
  for (const Step& step : order_) {
    if (step.loop) {
      const model::PlanarLoop& loop = loops_[step.index];
      const std::size_t a = loop.body_a, b = loop.body_b;
      join(a, bodies_[a].parent);
      join(a, bodies_[b].parent);
      join(b, a);
      continue;
    }
    const std::size_t b = step.index;
    join(b, bodies_[b].parent);
    for (std::size_t i = 0; i < kMaxSize; ++i)
      moves[b][i] = moves[b][i] || bodies_[b].map[i] != 0.0;
  }

  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    for (std::size_t i = 0; i < kMaxSize; ++i)
      if (moves[b][i]) frames_[b].columns.index[frames_[b].columns.count++] = i;
    if (base_[0] >= 0) frames_[b].jx[base_[0]] = 1.0;
    if (base_[1] >= 0) frames_[b].jz[base_[1]] = 1.0;
    if (base_[2] >= 0 && b == 0) frames_[b].w[base_[2]] = 1.0;
  }
}

void Mechanism::add_transmissions(const Plant& plant) {
  for (const Transmission& t : plant.transmissions) {
    if (t.compliance == 0.0 && t.play == 0.0) continue;
    const int motor = plant.model.motor_index(t.joint);
    if (motor < 0)
      throw InputError(fmt::format("transmission of '{}': no motor turns that joint", t.joint));
    if (n == kMaxSize)
      throw InputError(fmt::format("more than {} coordinates with the hinges", kMaxSize));
    const model::PlanarMotor& m = plant.model.motors[motor];
    Body& link = bodies_[m.body];
    if (m.rotor_inertia == 0.0) {
      // The link's inertia holds the rotor: half of it stays with the motor, so that a stiff hinge
      // leaves the robot as it was.
      Spin spin{link.parent, 0.5 * link.inertia, link.map};
      for (double& value : spin.row) value *= link.sign;
      link.inertia -= spin.inertia;
      spins_.push_back(spin);
    }
    link.map[n] = 1.0;
    hinges.push_back({motor, m.body, n, 0.5 * t.play});
    ++n;
  }
}

/// Links that a loop carries wait until both of its sides are placed.
void Mechanism::add_step_order(const model::PlanarModel& model) {
  std::vector<bool> placed(bodies_.size(), false);
  placed[0] = true;
  std::size_t count = 1;
  const auto is_placed = [&](int body) { return placed[body]; };

  for (bool progress = true; progress && count < bodies_.size();) {
    progress = false;
    for (int b = 1; b < count_of(bodies_); ++b) {
      if (placed[b] || bodies_[b].dependent || !is_placed(bodies_[b].parent)) continue;
      order_.push_back({false, b});
      placed[b] = progress = true;
      ++count;
    }
    for (int l = 0; l < count_of(model.loops); ++l) {
      const model::PlanarLoop& loop = model.loops[l];
      if (is_placed(loop.body_a) || !is_placed(bodies_[loop.body_a].parent) ||
          !is_placed(bodies_[loop.body_b].parent))
        continue;
      order_.push_back({true, l});
      placed[loop.body_a] = placed[loop.body_b] = progress = true;
      count += 2;
    }
  }

  assert(count == bodies_.size() && "every body hangs on the base");
}

void Mechanism::set_base(const double* q, const double* v) {
  Frame& f = frames_[0];
  const auto value = [&](std::size_t i) { return base_[i] < 0 ? base_pose_[i] : q[base_[i]]; };
  const auto rate = [&](std::size_t i) { return base_[i] < 0 ? 0.0 : v[base_[i]]; };
  f.px = value(0);
  f.pz = value(1);
  f.c = std::cos(value(2));
  f.s = std::sin(value(2));
  f.vx = rate(0);
  f.vz = rate(1);
  f.omega = rate(2);
  f.ax = f.az = f.alpha = 0.0;
}

/// Origin of a frame at r in the frame of its parent.
void Mechanism::place(const Frame& p, const Vec2& r, Frame& f) const {
  const Vec2 arm = carry(p, r, f);
  const double ex = arm.x(), ez = arm.y();
  for (const std::size_t i : p.columns) {
    f.jx[i] = p.jx[i] + ez * p.w[i];
    f.jz[i] = p.jz[i] - ex * p.w[i];
  }
}

void Mechanism::set_joint(int b, const double* q, const double* v) {
  const Body& body = bodies_[b];
  const Frame& p = frames_[body.parent];
  Frame& f = frames_[b];
  const double theta = dot(body.map, body.columns, q) + body.joint_offset,
               rate = dot(body.map, body.columns, v);
  if (!body.prismatic) {
    place(p, body.origin, f);
    const double angle = body.offset + body.sign * theta, c = std::cos(angle), s = std::sin(angle);
    f.c = p.c * c - p.s * s;
    f.s = p.s * c + p.c * s;
    f.omega = p.omega + body.sign * rate;
    f.alpha = p.alpha;
    for (const std::size_t i : f.columns) f.w[i] = p.w[i] + body.sign * body.map[i];
    return;
  }

  for (const std::size_t i : f.columns) f.jx[i] = f.jz[i] = 0.0;
  place(p, body.origin + body.axis * theta, f);
  const double ex = p.c * body.axis.x() + p.s * body.axis.y(),
               ez = -p.s * body.axis.x() + p.c * body.axis.y();
  f.vx += ex * rate;
  f.vz += ez * rate;
  f.ax += 2.0 * p.omega * rate * ez;
  f.az -= 2.0 * p.omega * rate * ex;

  for (const std::size_t i : f.columns) {
    f.jx[i] += ex * body.map[i];
    f.jz[i] += ez * body.map[i];
  }

  f.c = p.c * body.cos_offset - p.s * body.sin_offset;
  f.s = p.s * body.cos_offset + p.c * body.sin_offset;
  f.omega = p.omega;
  f.alpha = p.alpha;
  for (const std::size_t i : p.columns) f.w[i] = p.w[i];
}

bool Mechanism::close_loop(const model::PlanarLoop& loop) {
  const Body &link_a = bodies_[loop.body_a], &link_b = bodies_[loop.body_b];
  Frame &a = frames_[loop.body_a], &b = frames_[loop.body_b];
  place(frames_[link_a.parent], link_a.origin, a);
  place(frames_[link_b.parent], link_b.origin, b);
  const double ux = b.px - a.px, uz = b.pz - a.pz, distance2 = ux * ux + uz * uz;
  const double ra2 = loop.point_a.squaredNorm(), rb2 = loop.point_b.squaredNorm();
  // Where the roots meet, the links may turn freely: close to it their rates know no bound.
  if (!(distance2 > 1e-6 * ra2)) return false;
  const double along = 0.5 * (distance2 + ra2 - rb2) / distance2;  // of u
  const double height2 = ra2 - along * along * distance2;
  if (!(height2 > 1e-12 * ra2)) return false;  // stretched out, or the circles are concentric (NaN)
  const double across = loop.branch * std::sqrt(height2 / distance2);

  // Arms from the roots to the pin.
  const double ax = along * ux + across * uz, az = along * uz - across * ux, bx = ax - ux,
               bz = az - uz;
  a.c = (loop.point_a.x() * ax + loop.point_a.y() * az) / ra2;
  a.s = (loop.point_a.y() * ax - loop.point_a.x() * az) / ra2;
  b.c = (loop.point_b.x() * bx + loop.point_b.y() * bz) / rb2;
  b.s = (loop.point_b.y() * bx - loop.point_b.x() * bz) / rb2;

  // [e'_a -e'_b] (x_a, x_b) = (x, z), e'_a = (az, -ax).
  const double inverse = 1.0 / (az * bx - ax * bz);
  const auto solve_a = [&](double x, double z) { return (bx * x + bz * z) * inverse; };
  const auto solve_b = [&](double x, double z) { return (ax * x + az * z) * inverse; };
  for (const std::size_t i : a.columns) {
    const double x = b.jx[i] - a.jx[i], z = b.jz[i] - a.jz[i];
    a.w[i] = solve_a(x, z);
    b.w[i] = solve_b(x, z);
  }

  a.omega = solve_a(b.vx - a.vx, b.vz - a.vz);
  b.omega = solve_b(b.vx - a.vx, b.vz - a.vz);
  const double sa = a.omega * a.omega, sb = b.omega * b.omega;
  const double x = b.ax - bx * sb - a.ax + ax * sa, z = b.az - bz * sb - a.az + az * sa;
  a.alpha = solve_a(x, z);
  b.alpha = solve_b(x, z);
  return true;
}

bool Mechanism::set(const double* q, const double* v) {
  set_base(q, v);
  for (const Step& step : order_) {
    if (!step.loop) {
      set_joint(step.index, q, v);
    } else if (!close_loop(loops_[step.index])) {
      return false;
    }
  }
  return true;
}

void Mechanism::assemble(double* mass, double* bias) const {
  const std::size_t size = n;
  for (std::size_t j = 0; j < size; ++j) {
    for (std::size_t i = j; i < size; ++i) mass[j * kMaxSize + i] = armature_[j * kMaxSize + i];
    bias[j] = 0.0;
  }

  // Every body moves with the base's x and z alike, so these two columns are sums of the others'
  // rows.
  Row sum_x{}, sum_z{}, jx, jz;
  double total_x = 0.0, total_z = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = bodies_[b];
    const Frame& f = frames_[b];
    const double ex = f.c * body.com.x() + f.s * body.com.y(),
                 ez = -f.s * body.com.x() + f.c * body.com.y();
    const double square = f.omega * f.omega, m = body.mass, inertia = body.inertia;
    const double force_x = m * (f.ax + ez * f.alpha - ex * square + gravity_x_);
    const double force_z = m * (f.az - ex * f.alpha - ez * square + gravity_z_),
                 moment = inertia * f.alpha;
    total_x += force_x;
    total_z += force_z;
    for (const std::size_t i : f.columns) {
      jx[i] = f.jx[i] + ez * f.w[i];
      jz[i] = f.jz[i] - ex * f.w[i];
      sum_x[i] += m * jx[i];
      sum_z[i] += m * jz[i];
      bias[i] += jx[i] * force_x + jz[i] * force_z + f.w[i] * moment;
    }
    for (std::size_t k = 0; k < f.columns.count; ++k) {
      const std::size_t j = f.columns.index[k];
      const double x = m * jx[j], z = m * jz[j], w = inertia * f.w[j];
      double* column = mass + j * kMaxSize;
      for (std::size_t l = k; l < f.columns.count; ++l) {
        const std::size_t i = f.columns.index[l];
        column[i] += x * jx[i] + z * jz[i] + w * f.w[i];
      }
    }
  }

  const std::array<const Row*, 2> sums{&sum_x, &sum_z};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (base_[axis] < 0) continue;
    const std::size_t j = base_[axis];
    for (std::size_t i = j; i < size; ++i) mass[j * kMaxSize + i] += (*sums[axis])[i];
    mass[j * kMaxSize + j] += total_mass_;
    bias[j] += axis == 0 ? total_x : total_z;
  }

  if (!spins_.empty()) add_spins(mass, bias);
}

void Mechanism::add_spins(double* mass, double* bias) const {
  const std::size_t size = n;
  Row row;
  for (const Spin& spin : spins_) {
    const Frame& f = frames_[spin.body];
    for (std::size_t i = 0; i < size; ++i) {
      row[i] = f.w[i] + spin.row[i];
      bias[i] += row[i] * spin.inertia * f.alpha;
    }
    for (std::size_t j = 0; j < size; ++j)
      for (std::size_t i = j; i < size; ++i)
        mass[j * kMaxSize + i] += spin.inertia * row[j] * row[i];
  }
}

void Mechanism::point(int b, const Vec2& r, PointState& out) const {
  const Frame& f = frames_[b];
  const Vec2 arm = carry(f, r, out);
  const double ex = arm.x(), ez = arm.y();
  for (int i = 0; i < n; ++i) {
    out.jx[i] = f.jx[i];
    out.jz[i] = f.jz[i];
  }
  for (const std::size_t i : f.columns) {
    out.jx[i] += ez * f.w[i];
    out.jz[i] -= ex * f.w[i];
  }
}

void Mechanism::joint(int b, const double* q, const double* v, JointState& out) const {
  const Body& body = bodies_[b];
  if (!body.dependent) {
    out.row = body.map;
    out.value = dot(body.map, body.columns, q) + body.joint_offset;
    out.rate = dot(body.map, body.columns, v);
    out.bias = 0.0;
    return;
  }
  const Frame &f = frames_[b], &p = frames_[body.parent];
  const double c = f.c * p.c + f.s * p.s, s = f.s * p.c - f.c * p.s;  // of the angle to the parent
  const double c0 = body.cos_offset, s0 = body.sin_offset;
  out.value = body.sign * std::atan2(s * c0 - c * s0, c * c0 + s * s0);
  out.rate = body.sign * (f.omega - p.omega);
  out.bias = body.sign * (f.alpha - p.alpha);
  for (int i = 0; i < n; ++i) out.row[i] = body.sign * (f.w[i] - p.w[i]);
}

double Mechanism::motor_angle(int motor, const double* q) const {
  return dot(motor_row[motor], motor_columns[motor], q) + motor_offset_[motor];
}

double Mechanism::motor_rate(int motor, const double* v) const {
  return dot(motor_row[motor], motor_columns[motor], v);
}

}  // namespace jaculus::simulation::detail
