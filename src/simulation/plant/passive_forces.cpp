#include "simulation/plant/passive_forces.h"

#include <fmt/format.h>

#include <cmath>

#include "jaculus/components/tail_drag.h"
#include "jaculus/core/error.h"

namespace jaculus::simulation::detail {

namespace {

/// Torque at which a flank of a gear gives way by its play: stiffness of the flanks = this / play
/// [N m].
constexpr double kFlankTorque = 200.0;

}  // namespace

PassiveForces::PassiveForces(const Plant& plant) : plant_(plant) {
  const model::PlanarModel& model = plant.model;

  for (const JointFriction& f : plant.friction) {
    const int body = model.body_of_joint(f.joint);
    if (body < 0) throw InputError(fmt::format("friction: the robot has no joint '{}'", f.joint));
    if (f.coulomb == 0.0 && f.viscous == 0.0 && f.stribeck == 0.0 && f.load == 0.0) continue;
    const int motor = model.motor_index(f.joint);
    friction_.push_back(
        {&f, body, motor, motor < 0 ? model.bodies[body].count : model.motors[motor].count});
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
  if (!springs_.empty()) add_springs(mechanism, inertia, q, v, force);
  add_drag(mechanism, force);
}

void PassiveForces::add_friction(const Mechanism& mechanism, const std::vector<MotorState>& motors,
                                 const double* q, const double* v, double* force) const {
  for (const Friction& f : friction_) {
    const JointFriction& law = *f.law;
    double rate, load = 0.0;
    JointState joint;
    const Row* row = &joint.row;
    if (f.motor >= 0) {
      rate = mechanism.motor_rate(f.motor, v);
      row = &mechanism.motor_row[f.motor];
      load = law.load * std::abs(motors[f.motor].torque);
    } else {
      mechanism.joint(f.body, q, v, joint);
      const model::PlanarBody& link = plant_.model.bodies[f.body];
      rate = link.sign * (mechanism.frame(f.body).omega - mechanism.frame(link.parent).omega);
    }

    const double ratio = rate / law.stribeck_rate;
    const double level =
        law.coulomb + load + (law.stribeck == 0.0 ? 0.0 : law.stribeck * std::exp(-ratio * ratio));
    const double torque =
        -f.count * (std::tanh(rate / law.smoothing_rate) * level + law.viscous * rate);
    for (int i = 0; i < mechanism.n; ++i) force[i] += torque * (*row)[i];
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

    const double angle = q[i], b = spring.half_play, s2 = spring.smoothing * spring.smoothing;
    double beyond = angle, slope = 1.0;
    if (b > 0.0) {
      const double up = std::sqrt((angle - b) * (angle - b) + s2),
                   down = std::sqrt((angle + b) * (angle + b) + s2);
      beyond += 0.5 * (up - down);
      slope += 0.5 * ((angle - b) / up - (angle + b) / down);
    }
    force[i] -= spring.stiffness * beyond + spring.damping * slope * v[i];
  }
}

void PassiveForces::add_drag(const Mechanism& mechanism, double* force) const {
  for (const model::PlanarDrag& drag : plant_.model.drags) {
    if (drag.kind == model::DragKind::none || drag.coefficient == 0.0) continue;
    const Frame& f = mechanism.frame(drag.body);
    const Vec2& d = drag.direction;
    const double nx = -f.s * d.x() + f.c * d.y(), nz = -f.c * d.x() - f.s * d.y();
    const double s = nx * (f.vx - drag.wind_W.x()) + nz * (f.vz - drag.wind_W.y());

    const components::DragLoad load =
        components::drag_load(drag, s, f.omega, plant_.drag_smoothing);
    for (int i = 0; i < mechanism.n; ++i)
      force[i] += load.force * (nx * f.jx[i] + nz * f.jz[i]) + load.moment * f.w[i];
  }
}

}  // namespace jaculus::simulation::detail
