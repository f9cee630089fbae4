// Forces of drag, joint friction, hinges and compliant ground, and the torques that hold a pose.

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "jaculus/components/tail_drag.h"
#include "jaculus/core/error.h"
#include "simulation/plant_equations.h"

namespace jaculus::detail {

namespace {

/// Torque at which a flank of a gear gives way by its play: stiffness of the flanks = this / play [N m].
constexpr double kFlankTorque = 10.0;
/// A sole's tangential spring has a damper of this time constant beside it [s].
constexpr double kSoleTime = 1e-3;

}  // namespace

void PlantEquations::add_elements() {
  const PlanarModel& model = plant_.model;
  for (const JointFriction& f : plant_.friction) {
    const int body = model.body_of_joint(f.joint);
    if (body < 0) throw InputError(fmt::format("friction: the robot has no joint '{}'", f.joint));
    const int motor = model.motor_index(f.joint);
    const PlanarBody& link = model.bodies[static_cast<size_t>(body)];
    if (f.coulomb == 0.0 && f.viscous == 0.0 && f.stribeck == 0.0 && f.load == 0.0) continue;
    friction_.push_back({&f, body, motor, motor < 0 ? link.count : model.motors[static_cast<size_t>(motor)].count});
  }
  for (const Transmission& t : plant_.transmissions) {
    if (t.compliance == 0.0 && t.play == 0.0) continue;
    const int count = model.motors[static_cast<size_t>(model.motor_index(t.joint))].count;
    springs_.push_back({count / (t.compliance + t.play / kFlankTorque), t.damping_ratio, 0.5 * t.play, 0.1 * t.play});
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

/// Normal force of the floor (Hunt and Crossley), and a sole that is a spring and a damper side by side in series with a slider:
///     f_z = max(0, d/c (1 + D d')),   f_t = -(s + T v_t)/c within +-mu f_z,   s' = -(s + c f_t)/T   (= v_t while it sticks).
/// Forces are continuous in the state, so that stick and slip are no events here, only landing and lifting are.
void PlantEquations::add_ground(const double* y) {
  const Ground& ground = plant_.ground;
  const double* bristle = y + bristles();
  for (size_t i = 0; i < points_; ++i) {
    const ContactState& c = contacts[i];
    const double stiffness = unilaterals[i].count / ground.compliance;
    const double normal =
        modes[i] == Touch::open ? 0.0 : std::max(0.0, -stiffness * c.gap * (1.0 - ground.damping * c.normal_rate));
    const double free = -stiffness * (bristle[i] + kSoleTime * c.tangential_rate), cone = ground.friction * normal;
    const double tangential = std::clamp(free, -cone, cone);
    sole[i] = tangential == free ? Touch::stick : (free > 0.0 ? Touch::slip_minus : Touch::slip_plus);
    bristle_rate[i] = tangential == free ? c.tangential_rate : -(bristle[i] + tangential / stiffness) / kSoleTime;
    lambda[2 * i] = tangential;
    lambda[2 * i + 1] = normal;
    if (normal == 0.0) continue;
    for (size_t k = 0; k < static_cast<size_t>(n()); ++k)
      force_[k] += tangential * c.tangential[k] + normal * c.normal[k];
  }
}

/// Torques u that come nearest to keeping the accelerations zero: least |a(u)|^2, a being affine in u at given modes; of several
/// the smallest u. Commands hold them until the first command of the controller arrives.
bool PlantEquations::hold(double t, const double* y) {
  holding_ = true;
  drive.take(CommandQuantity::torque);
  const auto motors = static_cast<Eigen::Index>(drive.motors.size());
  hold_.assign(drive.motors.size(), {true, 0.0});
  std::vector<double> dydt(static_cast<size_t>(states()));
  const auto acceleration = [&](Vector& a) {
    const bool ok = evaluate(t, y, dydt.data());
    a = Eigen::Map<const Vector>(dydt.data() + n(), n());
    return ok;
  };
  Vector free, with;
  if (!acceleration(free)) return false;
  constexpr double kProbe = 0.1;  // a is affine in the torques, so the step is large for the sake of rounding [N m]
  Matrix response(n(), motors);
  for (Eigen::Index m = 0; m < motors; ++m) {
    hold_[static_cast<size_t>(m)].value = kProbe;
    if (!acceleration(with)) return false;
    response.col(m) = (with - free) / kProbe;
    hold_[static_cast<size_t>(m)].value = 0.0;
  }
  Eigen::CompleteOrthogonalDecomposition<Matrix> solver(response);
  solver.setThreshold(
      1e-7);  // feet that stand leave one combination of torques without effect: none of it is asked for
  const Vector torque = solver.solve(-free);
  for (Eigen::Index m = 0; m < motors; ++m) hold_[static_cast<size_t>(m)].value = torque[m];
  return true;
}

}  // namespace jaculus::detail
