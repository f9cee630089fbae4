#ifdef JACULUS_HAS_MUJOCO

// Things that no catalogue of effects holds: what hardware does when a cable drags, a connector is
// loose or somebody pushes.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "testbed/forces.h"

namespace jaculus::testbed {
namespace {

constexpr double kAdhesionRange = 4e-3;                  ///< over which a sticky floor lets go [m]
constexpr double kRippleWaves = 14.0;                    ///< magnet pairs of a brushless motor
constexpr double kPushStart = 0.08, kPushLength = 0.02;  ///< [s]

/// What the robot feels of a floor or bench that sways along x, seen from there.
void add_shaking(const Forces& forces, mjData& d) {
  const Disturbances& o = forces.changes->outside;
  const mjModel& m = *forces.machine->model;
  const double phase = 2.0 * std::numbers::pi * o.shaking_frequency * d.time;
  const double sway = o.shaking * std::sin(phase);
  for (int body = 1; body < m.nbody; ++body) d.xfrc_applied[6 * body] -= m.body_mass[body] * sway;
}

void add_pushes(const Forces& forces, mjData& d) {
  const Disturbances& o = forces.changes->outside;
  d.xfrc_applied[std::ptrdiff_t{6} * forces.machine->base] += push_at(o.base_push, d.time);
  if (o.joint_push.empty()) return;
  for (int i = 0; i < count_of(forces.files->drives); ++i) {
    const auto push = o.joint_push.find(forces.files->drives[i].planar);
    if (push == o.joint_push.end()) continue;
    d.qfrc_applied[forces.machine->drives[i].dof] += push_at(push->second, d.time);
  }
}

}  // namespace

double push_at(const Push& push, double time) {
  const double into = time - push.start;
  if (push.peak == 0.0 || into <= 0.0 || into >= push.length) return 0.0;
  return push.peak * std::sin(std::numbers::pi * into / push.length);
}

FailingDrives failing_drives(const RobotFiles& files) {
  const std::vector<std::string> rear = files.motors_of(Limb::rear_leg);
  std::vector<std::string> front = files.motors_of(Limb::front_leg);
  if (front.empty()) front = rear;

  FailingDrives out;
  if (front.empty() || rear.empty()) return out;
  out.derated = files.sides_of(front.back()).front();
  out.deaf = files.sides_of(rear.back()).back();
  out.slipping = files.sides_of(rear.front()).back();
  return out;
}

double disturbed_torque(const Forces& forces, int i, double torque, const mjData& d) {
  const Disturbances& o = forces.changes->outside;
  const Limb limb = forces.files->drives[i].limb;
  const bool leg = limb == Limb::front_leg || limb == Limb::rear_leg;

  if (o.ripple > 0.0 && leg)
    torque += o.ripple * std::sin(kRippleWaves * d.qpos[forces.machine->drives[i].qpos]);
  if (o.derating > 0.0 && d.time >= o.derating_start && i == forces.failing.derated)
    torque *= 1.0 - o.derating;
  const bool deaf =
      o.dropout > 0.0 && d.time >= o.dropout_start && d.time < o.dropout_start + o.dropout;
  if (deaf && i == forces.failing.deaf) torque = 0.0;
  if (i == forces.failing.slipping) torque = std::clamp(torque, -o.belt_slip, o.belt_slip);

  if (o.tail_cable > 0.0 && limb == Limb::tail) {
    const double q = d.qpos[forces.machine->drives[i].qpos];
    torque -= o.tail_cable * q * q * q;
  }
  return torque;
}

void add_disturbances(const Forces& forces, mjData& d) {
  const Disturbances& o = forces.changes->outside;
  const Machine& machine = *forces.machine;
  double* base = d.xfrc_applied + std::ptrdiff_t{6} * machine.base;
  if (o.tether_stiffness > 0.0 && machine.base_x.qpos >= 0) {
    const double taut = d.qpos[machine.base_x.qpos] - forces.start_x - o.tether_slack;
    if (taut > 0.0) base[0] -= o.tether_stiffness * taut;
  }

  if (o.push != 0.0 && d.time >= kPushStart && d.time < kPushStart + kPushLength) base[0] += o.push;
  add_pushes(forces, d);
  if (o.shaking != 0.0) add_shaking(forces, d);
  if (o.adhesion == 0.0) return;
  for (std::size_t i = 0; i < machine.toes.size(); ++i) {
    if (forces.files->toes[i].limb != Limb::rear_leg) continue;
    const int geom = machine.toes[i];
    const double height = d.geom_xpos[3 * geom + 2] - machine.model->geom_size[3 * geom];
    if (height >= kAdhesionRange) continue;
    const double pull = o.adhesion * std::min(1.0, 1.0 - height / kAdhesionRange);
    const model::Vec3 place(d.geom_xpos + 3 * geom);
    const int body = machine.model->geom_bodyid[geom];
    const model::Vec3 moment =
        (place - model::Vec3(d.xipos + 3 * body)).cross(model::Vec3(0.0, 0.0, -pull));
    d.xfrc_applied[6 * body + 2] -= pull;
    for (int k = 0; k < 3; ++k) d.xfrc_applied[6 * body + 3 + k] += moment[k];
  }
}

}  // namespace jaculus::testbed

#endif  // JACULUS_HAS_MUJOCO
