#ifdef JACULUS_HAS_MUJOCO

#include "testbed/static_tests.h"

#include <algorithm>
#include <cmath>

#include "testbed/machine.h"
#include "testbed/sizes.h"

namespace jaculus::testbed {
namespace {

/// Angle of the tail's joint at which the tail points along x.
double level_angle(const RobotFiles& files) {
  const model::SpatialTree& tree = files.tree;
  const model::SpatialLink& link = tree.links[tree.link_index(files.drag_links.front())];
  const Vec2& along = files.drags.front().direction;
  const model::Vec3 at_zero = link.R_BL * model::Vec3(along.x(), 0.0, along.y());
  const double turn = std::atan2(at_zero.z(), at_zero.x());
  return (link.R_BL * tree.joints[link.joint].axis).y() < 0.0 ? -turn : turn;
}

/// The first drive of a tail.
int tail_drive(const RobotFiles& files) {
  int i = 0;
  while (i < count_of(files.drives) && files.drives[i].limb != Limb::tail) ++i;
  return i;
}

/// The robot on a stand without gravity, its tail at `angle`.
Machine on_stand(const RobotFiles& files, const Changes& changes, bool stops, double angle,
                 Numerics& numerics) {
  numerics = numerics_for(files, changes, Numerics{});
  Machine machine = build_machine(files, changes, {false, true, stops}, numerics);
  std::fill_n(machine.model->opt.gravity, 3, 0.0);
  StartPose pose;
  for (const Drive& drive : files.drives)
    pose.joints[drive.joint] = drive.limb == Limb::tail ? angle : files.rest_of(drive.planar);
  place(machine, files, pose);
  return machine;
}

void hold_motors(Machine& machine) {
  for (const JointPlace& drive : machine.drives) machine.model->dof_armature[drive.dof] = 1e6;
}

/// Place of the scoop's middle along z, with the tail pointing along x.
double scoop_height(const Machine& machine) {
  const Strip& strip = machine.strips.front()[machine.strips.front().size() / 2];
  const mjData& d = *machine.data;
  return d.xpos[3 * strip.body + 2] + d.xmat[9 * strip.body + 6] * strip.point_B.x() +
         d.xmat[9 * strip.body + 8] * strip.point_B.z();
}

/// Lets a force along z at the scoop's middle act until nothing moves.
double height_under(Machine& machine, double force) {
  mjData& d = *machine.data;
  const Strip& strip = machine.strips.front()[machine.strips.front().size() / 2];
  const double seconds = 1.0;
  for (double end = d.time + seconds; d.time < end;) {
    std::fill_n(d.qfrc_applied, machine.model->nv, 0.0);
    const mjtNum push[3] = {0.0, 0.0, force}, none[3] = {0.0, 0.0, 0.0};
    mjtNum point[3];
    for (int k = 0; k < 3; ++k) {
      point[k] = d.xpos[3 * strip.body + k] + d.xmat[9 * strip.body + 3 * k] * strip.point_B.x() +
                 d.xmat[9 * strip.body + 3 * k + 2] * strip.point_B.z();
    }
    mj_applyFT(machine.model.get(), &d, push, none, point, strip.body, d.qfrc_applied);
    mj_step(machine.model.get(), &d);
  }
  return scoop_height(machine);
}

/// How far along x the scoop's middle is from the pivot, with the tail pointing that way [m].
double reach_of(const Machine& machine, const RobotFiles& files) {
  const Strip& strip = machine.strips.front()[machine.strips.front().size() / 2];
  const Vec2& along = files.drags.front().direction;
  return machine.data->xpos[3 * strip.body] +
         strip.point_B.dot(model::Vec3(along.x(), 0.0, along.y())) -
         machine.data->xpos[3 * machine.drag_pivot.front()];
}

double shaft_compliance(const RobotFiles& files, const Changes& changes) {
  Numerics numerics;
  Machine machine = on_stand(files, changes, false, level_angle(files), numerics);
  hold_motors(machine);
  for (int j = 0; j < machine.model->njnt; ++j) {
    const std::string name = mj_id2name(machine.model.get(), mjOBJ_JOINT, j);
    if (name.starts_with("tail_bend"))
      machine.model->dof_damping[machine.model->jnt_dofadr[j]] *= 10.0;
  }
  const double reach = reach_of(machine, files);
  const double force = 1.0;
  const double up = height_under(machine, force), down = height_under(machine, -force);
  return (up - down) / (2.0 * reach) / (force * reach);
}

double play(const RobotFiles& files, const Changes& changes) {
  Numerics numerics;
  Machine machine = on_stand(files, changes, false, level_angle(files), numerics);
  hold_motors(machine);
  const double reach = reach_of(machine, files);
  const double up = height_under(machine, 0.2), down = height_under(machine, -0.2);
  return (up - down) / reach;
}

double restitution(const RobotFiles& files, const Changes& changes) {
  Numerics numerics;
  const int tail = tail_drive(files);
  const double stop = files.joint_of(files.drives[tail].planar).range.upper;
  const double before = round_figure(stop - 0.17);  // 0.2 rad ahead of it, a hundredth of a second
  Machine machine = on_stand(files, changes, true, before, numerics);
  machine.model->opt.timestep = kStopStep * numerics.step;
  const int dof = machine.drives[tail].dof;
  for (const JointPlace& drive : machine.drives) {
    if (drive.dof != dof) machine.model->dof_armature[drive.dof] = 1e6;
  }

  mjData& d = *machine.data;
  const double speed = d.qvel[dof] = 20.0;
  double slowest = speed;
  while (d.time < 0.03) {
    mj_step(machine.model.get(), &d);
    slowest = std::min(slowest, d.qvel[dof]);
  }
  return std::max(0.0, -slowest / speed);
}

double plate_compliance(const RobotFiles& files, const Changes& changes) {
  const Numerics numerics = numerics_for(files, changes, Numerics{});
  Machine machine = build_machine(files, changes, {true, true, false}, numerics);
  mjData& d = *machine.data;
  machine.model->opt.disableflags |= mjDSBL_CONTACT | mjDSBL_EQUALITY;
  std::fill_n(machine.model->opt.gravity, 3, 0.0);
  const JointPlace plate = machine.joint("plate_0");
  const double load = 30.0;
  while (d.time < 0.5) {
    d.qfrc_applied[plate.dof] = -load;
    mj_step(machine.model.get(), &d);
  }
  return -d.qpos[plate.qpos] / load;
}

}  // namespace

std::vector<double> measured_parameters(const std::string& effect, const std::vector<double>& typed,
                                        const RobotFiles& files, const Changes& changes) {
  std::vector<double> values = typed;
  if (effect == "tail_compliance") {
    values = {shaft_compliance(files, changes), kNaN};
  } else if (effect == "tail_backlash") {
    values = {play(files, changes)};
  } else if (effect == "tail_stop_restitution") {
    values = {restitution(files, changes)};
  } else if (effect == "ground_compliance") {
    values = {plate_compliance(files, changes), kNaN};
  }
  return values;
}

}  // namespace jaculus::testbed

#endif  // JACULUS_HAS_MUJOCO
