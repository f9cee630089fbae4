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
constexpr double kFlankTorque = 200.0;
/// Along the floor a sole is stiffer than the floor under it by this factor, with a damper of this time constant beside the spring [s]:
/// plates give way downwards, and a sole's rubber shears by little.
constexpr double kSoleStiffness = 20.0, kSoleTime = 1e-4;

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
    springs_.push_back({count / (t.compliance + t.play / kFlankTorque), t.damping_ratio, 0.5 * t.play, 0.05 * t.play});
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

/// Normal force of the floor (Kelvin and Voigt, without pull; m: the robot's mass over its feet), and a sole that is a spring and a
/// damper side by side in series with a slider:
///     f_z = max(0, d/c + 2 zeta sqrt(m/c) d'),   f_t = -20 (s + T v_t)/c within +-mu f_z,
///     s' = -(s + c f_t/20)/T   (= v_t while it sticks).
/// Forces are continuous in the state, so that stick and slip are no events here, only landing and lifting are.
void PlantEquations::add_ground(const double* y) {
  const Ground& ground = plant_.ground;
  const double* bristle = y + bristles();
  for (size_t i = 0; i < points_; ++i) {
    const ContactState& c = contacts[i];
    const double stiffness = unilaterals[i].count / ground.compliance;
    const double damping = 2.0 * ground.damping_ratio * std::sqrt(stiffness * unilaterals[i].count * mass_of_foot_);
    const double normal = modes[i] == Touch::open ? 0.0 : std::max(0.0, -stiffness * c.gap - damping * c.normal_rate);
    const double shear = kSoleStiffness * stiffness, cone = ground.friction * normal;
    const double free = -shear * (bristle[i] + kSoleTime * c.tangential_rate);
    const double tangential = std::clamp(free, -cone, cone);
    sole[i] = tangential == free ? Touch::stick : (free > 0.0 ? Touch::slip_minus : Touch::slip_plus);
    bristle_rate[i] = tangential == free ? c.tangential_rate : -(bristle[i] + tangential / shear) / kSoleTime;
    lambda[2 * i] = tangential;
    lambda[2 * i + 1] = normal;
    if (normal == 0.0) continue;
    for (size_t k = 0; k < static_cast<size_t>(n()); ++k)
      force_[k] += tangential * c.tangential[k] + normal * c.normal[k];
  }
}

/// Hinges that no rigid contact loads; height and pitch where the floor gives way. Motors act on none of these rows.
std::vector<int> PlantEquations::loose_coordinates() const {
  std::vector<int> rows;
  for (const Hinge& hinge : mechanism.hinges) {
    const auto i = static_cast<size_t>(hinge.coordinate);
    const bool loaded = std::any_of(contacts.begin(), contacts.end(), [&](const ContactState& c) {
      return c.normal[i] != 0.0 || c.tangential[i] != 0.0;
    });
    if (!loaded || compliant_) rows.push_back(hinge.coordinate);
  }
  bool stands = false;
  for (size_t i = 0; i < modes.size(); ++i) stands = stands || (compliant(i) && modes[i] != Touch::open);
  for (const char* name : {"z", "pitch"})
    if (const int i = plant_.model.coordinate_index(name); stands && i >= 0) rows.push_back(i);
  return rows;
}

bool PlantEquations::unbalanced(double t, const double* y, const std::vector<int>& rows, Vector& out) {
  if (!set_state(y) || !set_mass()) return false;
  set_forces(t, y);
  out.resize(static_cast<Eigen::Index>(rows.size()));
  for (size_t k = 0; k < rows.size(); ++k) out[static_cast<Eigen::Index>(k)] = force_[rows[k]] - h_[rows[k]];
  return out.allFinite();
}

bool PlantEquations::rest(double t, double* y) {
  const std::vector<int> rows = loose_coordinates();
  if (rows.empty() || std::any_of(y + n(), y + 2 * n(), [](double rate) { return rate != 0.0; })) return true;
  constexpr double kStep = 1e-9;      // of differences; springs are stiff [rad, m]
  constexpr double kBalanced = 1e-9;  // of the weight
  Vector force, moved;
  if (!unbalanced(t, y, rows, force)) return false;
  const auto size = static_cast<Eigen::Index>(rows.size());
  for (int pass = 0; pass < 60 && force.norm() > kBalanced * force_scale; ++pass) {
    Matrix jacobian(size, size);
    for (Eigen::Index k = 0; k < size; ++k) {
      double& own = y[rows[static_cast<size_t>(k)]];
      const double was = own;
      own += kStep;
      const bool ok = unbalanced(t, y, rows, moved);
      own = was;
      if (!ok) return false;
      jacobian.col(k) = (moved - force) / kStep;
    }
    const Vector step = jacobian.colPivHouseholderQr().solve(-force);
    for (double share = 1.0;; share *= 0.5) {  // the flanks of a play begin softly, so that a whole step may overshoot
      for (Eigen::Index k = 0; k < size; ++k) y[rows[static_cast<size_t>(k)]] += share * step[k];
      if (unbalanced(t, y, rows, moved) && moved.norm() < force.norm()) break;
      for (Eigen::Index k = 0; k < size; ++k) y[rows[static_cast<size_t>(k)]] -= share * step[k];
      if (share < 1e-6) return force.norm() < 1e-4 * force_scale;
    }
    force = moved;
  }
  return true;
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
  Eigen::CompleteOrthogonalDecomposition<Matrix> solver(response.rows(), response.cols());
  // Feet that stand leave one combination of torques without effect: none of it is asked for. The rank is settled as it is factorised.
  solver.setThreshold(1e-7);
  solver.compute(response);
  const Vector torque = solver.solve(-free);
  for (Eigen::Index m = 0; m < motors; ++m) hold_[static_cast<size_t>(m)].value = torque[m];
  return true;
}

}  // namespace jaculus::detail
