#ifdef JACULUS_HAS_MUJOCO

#include "testbed/forces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "testbed/joint_changes.h"

namespace jaculus::testbed {
namespace {

thread_local Forces* current = nullptr;

void callback(const mjModel*, mjData* d) {
  if (current != nullptr) current->apply(*d);
}

/// Planar velocity (x, z) of a point fixed to a body, and its place.
void point_motion(const mjModel& m, const mjData& d, int body, const model::Vec3& point_B,
                  model::Vec3& place, model::Vec3& velocity) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> turn(d.xmat + 9 * body);
  const model::Vec3 origin(d.xpos + 3 * body);
  place = origin + turn * point_B;
  std::array<mjtNum, 6> motion{};  // rotation, then velocity of the body's frame
  mj_objectVelocity(&m, &d, mjOBJ_XBODY, body, motion.data(), 0);
  const model::Vec3 spin(motion[0], motion[1], motion[2]), rate(motion[3], motion[4], motion[5]);
  velocity = rate + spin.cross(place - origin);
}

}  // namespace

ForcesGuard::ForcesGuard(Forces& forces) {
  current = &forces;
  mjcb_control = callback;
}

ForcesGuard::~ForcesGuard() { current = nullptr; }

void add_drag(const Machine& machine, std::size_t index, const model::PlanarDrag& drag,
              const Changes& changes, mjData& d) {
  if (drag.kind == model::DragKind::none) return;
  const mjModel& m = *machine.model;
  const double factor =
      0.5 * drag.density * drag.coefficient * changes.drag_coefficient * drag.width;
  const model::Vec3 along(drag.direction.x(), 0.0, drag.direction.y());
  model::Vec3 pivot, carried = model::Vec3::Zero();
  point_motion(m, d, machine.drag_pivot[index], model::Vec3::Zero(), pivot, carried);

  for (const Strip& strip : machine.strips[index]) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> turn(d.xmat +
                                                                              9 * strip.body);
    const model::Vec3 tail = turn * along;
    // the way the strip goes as the tail's pitch grows
    const model::Vec3 normal(tail.z(), 0.0, -tail.x());
    model::Vec3 place, velocity;
    point_motion(m, d, strip.body, strip.point_B, place, velocity);
    velocity.x() -= drag.wind_W.x() + changes.wind;
    velocity.z() -= drag.wind_W.y();
    if (changes.drag_ignores_translation) velocity -= carried;
    const double u = normal.dot(velocity);
    const model::Vec3 force = -factor * u * std::abs(u) * strip.length * normal;
    // Equation 2 knows the moment about the pivot alone: a couple.
    const model::Vec3 from =
        changes.drag_ignores_translation ? pivot : model::Vec3(d.xipos + 3 * strip.body);
    const model::Vec3 moment = (place - from).cross(force);
    for (int k = 0; k < 3; ++k) {
      if (!changes.drag_ignores_translation) d.xfrc_applied[6 * strip.body + k] += force[k];
      d.xfrc_applied[6 * strip.body + 3 + k] += moment[k];
    }
  }
}

void Forces::begin(const mjData& d) {
  start_x = machine->base_x.qpos < 0 ? 0.0 : d.qpos[machine->base_x.qpos];
  sizes.clear();
  memory.clear();
  for (int i = 0; i < count_of(files->drives); ++i) {
    sizes.push_back(size_of(*files, files->drives[i]));
    memory.push_back({d.qpos[machine->drives[i].qpos]});
  }
}

void Forces::apply(mjData& d) {
  const mjModel& m = *machine->model;
  std::fill_n(d.qfrc_applied, m.nv, 0.0);
  std::fill_n(d.xfrc_applied, 6 * m.nbody, 0.0);
  rates.resize(machine->drives.size());
  for (std::size_t i = 0; i < rates.size(); ++i) rates[i] = d.qvel[machine->drives[i].dof];
  bus = drives->run(commands, rates, states);
  for (int i = 0; i < count_of(rates); ++i) {
    states[i].torque = disturbed_torque(*this, i, states[i].torque, d);
    const JointPlace& joint = machine->drives[i];
    const JointMotion now{d.qpos[joint.qpos], d.qvel[joint.dof], states[i].torque};
    const Drive& drive = files->drives[i];
    d.qfrc_applied[joint.dof] +=
        now.torque + torque_offset(*changes, drive) +
        torque_of_laws(changes->outside.joints, sizes[i], drive, memory[i], now);
  }
  for (std::size_t i = 0; i < files->drags.size(); ++i)
    add_drag(*machine, i, files->drags[i], *changes, d);
  add_disturbances(*this, d);
}

void Forces::renew_friction() {
  const JointDisturbances& o = changes->outside.joints;
  for (int i = 0; i < count_of(machine->drives); ++i) {
    const JointPlace& joint = machine->drives[i];
    memory[i] = moved(o, sizes[i], memory[i], machine->data->qpos[joint.qpos]);

    const double torque = i < count_of(states) ? std::abs(states[i].torque) : 0.0;
    const double rate = machine->data->qvel[joint.dof];
    machine->model->dof_frictionloss[joint.dof] =
        dry_friction(*changes, files->drives[i], rate, torque) +
        friction_of_laws(o, sizes[i], files->drives[i], memory[i]);
  }
}

}  // namespace jaculus::testbed

#endif  // JACULUS_HAS_MUJOCO
