#include "simulation/plant/passive_forces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/components/motor.h"
#include "jaculus/components/tail_drag.h"
#include "jaculus/core/error.h"

namespace jaculus::simulation::detail {

namespace {

/// Torque at which a flank of a gear gives way by its play: stiffness of the flanks = this / play
/// [N m].
constexpr double kFlankTorque = 200.0;
/// Angle between a loop's links at the pin below which they meet [rad].
constexpr double kLinksMeet = 0.1;

/// Angle between two arms, from their cross and dot products, or what is left to a straight angle,
/// whichever is smaller. `sense`: of its change with the first arm's angle less the second's.
double angle_left(double cross, double dot, double& sense) {
  const double folded = std::atan2(std::abs(cross), std::abs(dot));
  sense = (cross > 0.0) == (dot > 0.0) ? 1.0 : -1.0;
  return folded;
}

/// What a hinge's angle has beyond a dead band, and its slope [rad, -].
struct Beyond {
  double angle, slope;
};

/// With x = |angle| - b at a band of +-b whose corners are round over +-s: 0 below -s,
/// (x + s)^2/(4 s) between, x above s. Within the band nothing pulls at all: a law that is smooth
/// everywhere holds the middle by a spring, which is stiff beside the torques of a light joint.
Beyond beyond_play(double angle, double b, double s) {
  const double x = std::abs(angle) - b;
  if (x >= s) return {std::copysign(x, angle), 1.0};
  if (x <= -s) return {0.0, 0.0};
  const double in = x + s;
  return {std::copysign(0.25 * in * in / s, angle), 0.5 * in / s};
}

/// Of dry friction at a rate, `sign` the smoothed sign of which, and a motor's torque `load`.
double dry_level(const JointFriction& law, double rate, double sign, double load) {
  const double ratio = rate / law.stribeck_rate, slow = rate / law.load_stribeck_rate;
  const double load_at_rest = law.load_stribeck * load;
  return law.coulomb + law.load * load +
         (law.stribeck == 0.0 ? 0.0 : law.stribeck * std::exp(-ratio * ratio)) +
         (load_at_rest == 0.0 ? 0.0 : load_at_rest * std::exp(-slow * slow)) +
         0.5 * (law.positive * (1.0 + sign) + law.negative * (1.0 - sign));
}

}  // namespace

PassiveForces::PassiveForces(const Plant& plant) : plant_(plant) {
  const model::PlanarModel& model = plant.model;

  for (const JointFriction& f : plant.friction) {
    const int body = model.body_of_joint(f.joint);
    if (body < 0) throw InputError(fmt::format("friction: the robot has no joint '{}'", f.joint));
    const bool rubs = f.coulomb != 0.0 || f.viscous != 0.0 || f.stribeck != 0.0 || f.load != 0.0 ||
                      f.positive != 0.0 || f.negative != 0.0 || f.load_stribeck != 0.0;
    if (!rubs) continue;
    const int motor = model.motor_index(f.joint);
    friction_.push_back(
        {&f, body, motor, motor < 0 ? model.bodies[body].count : model.motors[motor].count});
  }

  for (int m = 0; m < count_of(model.motors); ++m)
    if (components::rubs(model.motors[m])) rubbing_.push_back({m, model.motors[m]});

  for (const auto& [joint, torque] : plant.actuation.torque_offset) {
    const int motor = model.motor_index(joint);
    if (motor < 0)
      throw InputError(fmt::format("torque offset: the robot has no motor at '{}'", joint));
    if (torque != 0.0) offsets_.push_back({motor, model.motors[motor].count * torque});
  }

  for (const Transmission& t : plant.transmissions) {
    if (t.compliance == 0.0 && t.play == 0.0) continue;
    const int count = model.motors[model.motor_index(t.joint)].count;
    springs_.push_back({count / (t.compliance + t.play / kFlankTorque), t.damping_ratio,
                        0.5 * t.play, 0.05 * t.play});
  }
}

void PassiveForces::add(const Mechanism& mechanism, const Inertia& inertia,
                        const std::vector<MotorState>& motors, const double* q, const double* v,
                        double* force) {
  if (!friction_.empty()) add_friction(mechanism, motors, q, v, force);
  if (!rubbing_.empty()) add_motor_friction(mechanism, v, force);
  for (const Offset& offset : offsets_)
    for (int i = 0; i < mechanism.n; ++i)
      force[i] += offset.torque * mechanism.motor_row[offset.motor][i];
  if (!springs_.empty()) add_springs(mechanism, inertia, q, v, force);
  add_drag(mechanism, force);
  if (!plant_.model.loops.empty()) add_loop_ends(mechanism, force);
}

void PassiveForces::add_motor_friction(const Mechanism& mechanism, const double* v,
                                       double* force) const {
  for (const MotorRub& rub : rubbing_) {
    const double rate = mechanism.motor_rate(rub.motor, v);
    const double torque = rub.data.count * components::motor_friction(rub.data, rate).value;
    for (int i = 0; i < mechanism.n; ++i) force[i] += torque * mechanism.motor_row[rub.motor][i];
  }
}

PassiveForces::Rubbing PassiveForces::rubbing(const Friction& f, const Mechanism& mechanism,
                                              const std::vector<MotorState>& motors,
                                              const double* q, const double* v,
                                              JointState& state) const {
  Rubbing joint;
  double load = 0.0;
  if (f.motor >= 0) {
    joint.rate = mechanism.motor_rate(f.motor, v);
    joint.row = &mechanism.motor_row[f.motor];
    load = std::abs(motors[f.motor].torque);
  } else {
    mechanism.joint(f.body, q, v, state);
    joint.rate = state.rate;
    joint.row = &state.row;
  }

  joint.sign = std::tanh(joint.rate / f.law->smoothing_rate);
  joint.level = dry_level(*f.law, joint.rate, joint.sign, load);
  return joint;
}

void PassiveForces::add_friction(const Mechanism& mechanism, const std::vector<MotorState>& motors,
                                 const double* q, const double* v, double* force) const {
  JointState state;
  for (const Friction& f : friction_) {
    const Rubbing joint = rubbing(f, mechanism, motors, q, v, state);
    const double torque = -f.count * (joint.sign * joint.level + f.law->viscous * joint.rate);
    for (int i = 0; i < mechanism.n; ++i) force[i] += torque * (*joint.row)[i];
  }
}

void PassiveForces::add_springs(const Mechanism& mechanism, const Inertia& inertia, const double* q,
                                const double* v, double* force) {
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    Spring& spring = springs_[k];
    const int i = mechanism.hinges[k].coordinate;
    if (spring.damping < 0.0)
      spring.damping =
          2.0 * spring.damping_ratio * std::sqrt(spring.stiffness * inertia.diagonal(i));

    const Beyond d = beyond_play(q[i], spring.half_play, spring.smoothing);
    force[i] -= spring.stiffness * d.angle + spring.damping * d.slope * v[i];
  }
}

void PassiveForces::list_fast_parts(const Mechanism& mechanism,
                                    const std::vector<MotorState>& motors, const double* q,
                                    const double* v, std::vector<FastPart>& parts) const {
  parts.clear();
  JointState state;
  for (const Friction& f : friction_) {
    const Rubbing joint = rubbing(f, mechanism, motors, q, v, state);
    const double slope = (1.0 - joint.sign * joint.sign) * joint.level / f.law->smoothing_rate;
    parts.push_back({.row = *joint.row,
                     .damping = f.count * (slope + f.law->viscous),
                     .speed = joint.rate,
                     .width = f.law->smoothing_rate});
  }

  for (const MotorRub& rub : rubbing_) {
    const double rate = mechanism.motor_rate(rub.motor, v);
    const double slope = components::motor_friction(rub.data, rate).d_rate;
    const bool dry = rub.data.dry_friction != 0.0;
    parts.push_back({.row = mechanism.motor_row[rub.motor],
                     .damping = -rub.data.count * slope,
                     .speed = rate,
                     .width = dry ? components::kDryFrictionSmoothing : 0.0});
  }

  for (std::size_t k = 0; k < springs_.size(); ++k) {
    const Spring& spring = springs_[k];
    const int i = mechanism.hinges[k].coordinate;
    const double slope = beyond_play(q[i], spring.half_play, spring.smoothing).slope;
    FastPart hinge{{}, slope * spring.damping, slope * spring.stiffness};
    hinge.row[i] = 1.0;
    parts.push_back(hinge);
  }
}

void PassiveForces::add_drag(const Mechanism& mechanism, double* force) const {
  for (const model::PlanarDrag& drag : plant_.model.drags) {
    if (drag.kind == model::DragKind::none || drag.coefficient == 0.0) continue;
    const Frame& f = mechanism.frame(drag.body);
    const Vec2& d = drag.direction;
    const double nx = -f.s * d.x() + f.c * d.y(), nz = -f.c * d.x() - f.s * d.y();
    const double s = nx * (f.vx - drag.wind_W.x()) + nz * (f.vz - drag.wind_W.y());

    const components::DragForce load =
        components::drag_force(drag, s, f.omega, plant_.drag_smoothing);
    for (int i = 0; i < mechanism.n; ++i)
      force[i] += load.force * (nx * f.jx[i] + nz * f.jz[i]) + load.moment * f.w[i];
  }
}

void PassiveForces::add_loop_ends(const Mechanism& mechanism, double* force) const {
  for (const model::PlanarLoop& loop : plant_.model.loops) {
    const Frame &a = mechanism.frame(loop.body_a), &b = mechanism.frame(loop.body_b);
    const Vec2 &ra = loop.point_a, &rb = loop.point_b;
    const double ax = a.c * ra.x() + a.s * ra.y(), az = a.c * ra.y() - a.s * ra.x();
    const double bx = b.c * rb.x() + b.s * rb.y(), bz = b.c * rb.y() - b.s * rb.x();
    const double cross = ax * bz - az * bx, dot = ax * bx + az * bz;
    // tan(0.1) > 0.1: the usual case is told without an arc tangent.
    if (std::abs(cross) > 1.1 * kLinksMeet * std::abs(dot)) continue;
    double sense;
    const double left = angle_left(cross, dot, sense);
    if (left >= kLinksMeet) continue;

    const double length = std::sqrt(ra.squaredNorm()) + std::sqrt(rb.squaredNorm());
    const double gravity = std::max(plant_.model.gravity, 1.0);
    const double scale = plant_.model.total_mass() * gravity * length;
    const double rate = sense * (a.omega - b.omega);
    const double damped = 1.0 - rate / std::sqrt(gravity / length);
    const double torque = scale * (kLinksMeet / left - 1.0) * std::max(0.0, damped);
    for (int i = 0; i < mechanism.n; ++i) force[i] += torque * sense * (a.w[i] - b.w[i]);
  }
}

}  // namespace jaculus::simulation::detail
