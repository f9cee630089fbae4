#ifdef JACULUS_HAS_MUJOCO

#include "jaculus/testbed/playback.h"

#include <algorithm>
#include <cmath>

#include "testbed/forces.h"
#include "testbed/loop.h"

namespace jaculus::testbed {
namespace {

constexpr double kInstant = 1e-9;  ///< closer events are one [s]

/// Grows column by column; MuJoCo's step count isn't known beforehand where commands arrive at odd
/// times.
struct Log {
  std::vector<double> time;
  std::vector<std::vector<double>> rows;  ///< all quantities of one instant

  void take(const Machine& machine, const Forces& forces, double at_time) {
    const mjData& d = *machine.data;
    time.push_back(at_time);
    std::vector<double> row;
    for (const JointPlace& j : {machine.base_x, machine.base_z, machine.base_pitch}) {
      row.push_back(j.qpos < 0 ? 0.0 : d.qpos[j.qpos]);
      row.push_back(j.dof < 0 ? 0.0 : d.qvel[j.dof]);
    }

    for (std::size_t i = 0; i < machine.drives.size(); ++i) {
      row.push_back(d.qpos[machine.drives[i].qpos]);
      row.push_back(d.qvel[machine.drives[i].dof]);
      row.push_back(forces.states[i].torque);
      row.push_back(forces.states[i].current);
      row.push_back(forces.states[i].voltage);
    }

    row.push_back(forces.bus);
    std::vector<double> toes(machine.toes.size(), 0.0);
    for (int c = 0; c < d.ncon; ++c) {
      if (d.contact[c].efc_address < 0) continue;
      for (std::size_t i = 0; i < toes.size(); ++i) {
        if (d.contact[c].geom1 != machine.toes[i] && d.contact[c].geom2 != machine.toes[i])
          continue;
        std::array<mjtNum, 6> force{};
        mj_contactForce(machine.model.get(), &d, c, force.data());
        toes[i] += force[0];
      }
    }
    row.insert(row.end(), toes.begin(), toes.end());
    rows.push_back(std::move(row));
  }
};

Recording recording_of(const Log& log, const RobotFiles& files) {
  const auto samples = std::ssize(log.time);
  const auto motors = std::ssize(files.drives);
  const auto toes = std::ssize(files.toes);
  Recording r;
  r.time = Eigen::Map<const Vector>(log.time.data(), samples);
  for (Matrix* matrix : {&r.base, &r.base_rate}) matrix->resize(3, samples);
  for (Matrix* matrix : {&r.position, &r.velocity, &r.torque, &r.current, &r.voltage})
    matrix->resize(motors, samples);
  r.bus_voltage.resize(samples);
  r.foot_force.resize(toes, samples);

  for (const Drive& drive : files.drives) {
    r.motors.push_back(drive.joint);
    r.motor_of.push_back(drive.planar);
  }

  for (const Toe& toe : files.toes) r.toes.push_back(toe.name);
  for (Eigen::Index k = 0; k < samples; ++k) {
    auto value = log.rows[k].begin();
    for (Eigen::Index i = 0; i < 3; ++i) {
      r.base(i, k) = *value++;
      r.base_rate(i, k) = *value++;
    }
    for (Eigen::Index i = 0; i < motors; ++i) {
      for (Matrix* matrix : {&r.position, &r.velocity, &r.torque, &r.current, &r.voltage})
        (*matrix)(i, k) = *value++;
    }
    r.bus_voltage[k] = *value++;
    for (Eigen::Index i = 0; i < toes; ++i) r.foot_force(i, k) = *value++;
  }

  r.duty = r.voltage.array().rowwise() / r.bus_voltage.transpose().array();
  return r;
}

StartPose start_pose(const RobotFiles& files, const Changes& changes, const PlayOptions& options) {
  StartPose pose;
  pose.level = options.level;
  for (const auto& [name, value] : options.start) {
    if (name == "x") pose.x = value;
    if (name == "pitch") pose.pitch = value;
    if (name == "z" && !options.floor) pose.z = value;
    if (name == "x" || name == "z" || name == "pitch") continue;

    // The robot takes its pose by its encoders.
    const auto offset = changes.joint_offset.find(name);
    const auto scale = changes.scale.find(name);
    const double by = offset == changes.joint_offset.end() ? 0.0 : offset->second;
    const double factor = scale == changes.scale.end() ? 1.0 : scale->second;
    const std::vector<int> sides = files.sides_of(name);
    if (sides.empty()) pose.joints[name] = (value - by) / factor;
    for (const int i : sides) {
      const Drive& drive = files.drives[i];
      const JointSize size = size_of(files, drive);
      const double seen = value - drive.encoder_zero - by;
      double& angle = pose.joints[drive.joint] = seen / factor;
      // contracts by the runout, a tenth at most, each time
      for (int k = 0; k < 16; ++k)
        angle = (seen - misreading(changes.outside.joints, size, angle)) / factor;
      // Where they would show it beyond its stop, it rests against that.
      const Bounds& range = files.joint_of(name).range;
      if (options.stops) angle = std::clamp(angle, range.lower, range.upper);
    }
  }
  if (!options.floor && std::isnan(pose.z)) pose.z = 0.0;
  return pose;
}

/// Whether a joint is at its stop or meets it within 3 ms.
bool near_stop(const Machine& machine) {
  const mjModel& m = *machine.model;
  for (int t = 0; t < m.ntendon; ++t) {
    const double reach = 3e-3 * std::abs(machine.data->ten_velocity[t]);
    const double q = machine.data->ten_length[t];
    if (q - reach < m.tendon_range[2 * t] + 0.01 || q + reach > m.tendon_range[2 * t + 1] - 0.01)
      return true;
  }
  for (int j = 0; j < m.njnt; ++j) {
    // play is no stop
    if (m.jnt_limited[j] == 0 || m.jnt_range[2 * j + 1] - m.jnt_range[2 * j] < 0.2) continue;
    const double q = machine.data->qpos[m.jnt_qposadr[j]],
                 reach = 3e-3 * std::abs(machine.data->qvel[m.jnt_dofadr[j]]);
    if (q - reach < m.jnt_range[2 * j] + 0.01 || q + reach > m.jnt_range[2 * j + 1] - 0.01)
      return true;
  }
  return false;
}

bool lost(const mjData& d) {
  return d.warning[mjWARN_BADQPOS].number > 0 || d.warning[mjWARN_BADQVEL].number > 0 ||
         d.warning[mjWARN_BADQACC].number > 0;
}

}  // namespace

Recording play(const RobotFiles& files, const Changes& changes, const Commands& commands,
               const PlayOptions& options, const Numerics& wanted) {
  const Numerics numerics = numerics_for(files, changes, wanted);
  const Setting setting{options.floor, options.base_fixed, options.stops};
  Machine machine = build_machine(files, changes, setting, numerics);
  Drives drives(files, changes, commands.quantity);
  Loop loop(files, changes, commands, options.sensors);
  Forces forces;
  forces.files = &files;
  forces.changes = &changes;
  forces.machine = &machine;
  forces.drives = &drives;
  forces.failing = failing_drives(files);
  forces.commands.assign(files.drives.size(), kNaN);
  place(machine, files, start_pose(files, changes, options));
  settle(machine);
  mjData& d = *machine.data;
  forces.begin(d);
  const ForcesGuard guard(forces);
  Log log;
  std::vector<double> angles(files.drives.size()), rates(files.drives.size());
  bool diverged = false;
  double waited = 0.0;  // until the first command arrived [s]
  forces.apply(d);

  while (true) {
    for (std::size_t i = 0; i < angles.size(); ++i) {
      angles[i] = d.qpos[machine.drives[i].qpos];
      rates[i] = d.qvel[machine.drives[i].dof];
    }
    while (loop.next() <= d.time + kInstant || loop.waiting()) {
      waited = std::max(waited, loop.next());
      loop.update(std::max(d.time, loop.next()) + kInstant, angles, rates);
      forces.commands = loop.now();
    }
    if (waited > d.time + kInstant) {
      log.take(machine, forces, 0.0);
      d.time = waited;
    }
    forces.apply(d);
    forces.renew_friction();
    log.take(machine, forces, d.time);
    if (d.time >= options.duration - kInstant) break;
    const double until = std::min(loop.next(), options.duration);
    const double left = until - d.time;
    // Equal steps up to the next event, so that none is tiny.
    const double step =
        options.stops && near_stop(machine) ? kStopStep * numerics.step : numerics.step;
    machine.model->opt.timestep = left / std::ceil(left / step - 1e-6);
    mj_step(machine.model.get(), &d);
    drives.warm(forces.states, machine.model->opt.timestep);
    diverged = lost(d);
    if (diverged) break;
  }

  Recording recording = recording_of(log, files);
  recording.diverged = diverged;
  recording.end_time = log.time.back();
  return recording;
}

}  // namespace jaculus::testbed

#endif  // JACULUS_HAS_MUJOCO
