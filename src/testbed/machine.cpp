#ifdef JACULUS_HAS_MUJOCO

#include "testbed/machine.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "jaculus/testbed/lost.h"

namespace jaculus::testbed {
namespace {

std::unique_ptr<mjModel, ModelDeleter> compile(const std::string& text) {
  // MuJoCo reads model text from a file of its virtual file system only.
  mju_user_warning = [](const char*) {
  };  // its own writes a log file into the working folder; data->warning keeps counts
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  const char* name = "robot.xml";
  mj_makeEmptyFileVFS(files.get(), name, count_of(text));
  const int index = mj_findFileVFS(files.get(), name);
  std::memcpy(files->filedata[index], text.data(), text.size());
  std::array<char, 1000> error{};
  std::unique_ptr<mjModel, ModelDeleter> model(
      mj_loadXML(name, files.get(), error.data(), count_of(error)));
  mj_deleteVFS(files.get());
  if (!model) throw LostRobot(fmt::format("MuJoCo does not take the robot: {}", error.data()));
  return model;
}

int body_id(const Machine& machine, const std::string& name) {
  return mj_name2id(machine.model.get(), mjOBJ_BODY, name.c_str());
}

/// Strips from L0 to L, each on the piece of the shaft that carries it.
std::vector<Strip> cut_strips(const Machine& machine, const model::PlanarDrag& drag,
                              const std::string& link, const std::vector<double>& hinges,
                              int count) {
  std::vector<Strip> strips;
  const model::Vec3 along(drag.direction.x(), 0.0, drag.direction.y());
  const double length = (drag.end - drag.start) / count;
  for (int i = 0; i < count; ++i) {
    const double l = drag.start + (i + 0.5) * length;
    Strip strip{body_id(machine, link), l * along, length};
    for (std::size_t h = 0; h < hinges.size() && hinges[h] < l; ++h) {
      strip.body = body_id(machine, fmt::format("tail_piece_{}", h + 1));
      strip.point_B = (l - hinges[h]) * along;
    }
    strips.push_back(strip);
  }
  return strips;
}

model::Vec3 site(const Machine& machine, std::size_t pin, char end) {
  const int id =
      mj_name2id(machine.model.get(), mjOBJ_SITE, fmt::format("pin_{}_{}", pin, end).c_str());
  return model::Vec3(machine.data->site_xpos + 3 * id);
}

/// Column (x, z) of how the gap of a pin changes with one joint.
Vec2 gap_rate(const Machine& machine, std::size_t pin, int dof) {
  std::vector<double> a(3 * machine.model->nv), b(a.size());
  const auto id = [&](char end) {
    return mj_name2id(machine.model.get(), mjOBJ_SITE, fmt::format("pin_{}_{}", pin, end).c_str());
  };
  mj_jacSite(machine.model.get(), machine.data.get(), a.data(), nullptr, id('a'));
  mj_jacSite(machine.model.get(), machine.data.get(), b.data(), nullptr, id('b'));
  const std::size_t nv = machine.model->nv, d = dof;
  return {a[d] - b[d], a[2 * nv + d] - b[2 * nv + d]};
}

void kinematics(Machine& machine) {
  mj_kinematics(machine.model.get(), machine.data.get());
  mj_comPos(machine.model.get(), machine.data.get());
}

/// Newton on the two joints of a pin, at most half a radian a step; the gap that is left [m].
double close_pin(Machine& machine, std::size_t p, const JointPlace& a, const JointPlace& b) {
  double gap = kInfinity;
  for (int i = 0; i < 60 && gap > 1e-15; ++i) {
    kinematics(machine);
    const model::Vec3 d = site(machine, p, 'a') - site(machine, p, 'b');
    gap = std::hypot(d.x(), d.z());

    Mat2 jacobian;
    jacobian << gap_rate(machine, p, a.dof), gap_rate(machine, p, b.dof);
    const Vec2 turn = -jacobian.fullPivLu().solve(Vec2(d.x(), d.z()));
    const double scale = std::min(1.0, 0.5 / std::max(1e-12, turn.cwiseAbs().maxCoeff()));
    machine.data->qpos[a.qpos] += scale * turn.x();
    machine.data->qpos[b.qpos] += scale * turn.y();
  }
  kinematics(machine);
  return gap;
}

/// Whether a pin lies on its side of the line between the two links' joints.
bool on_branch(const Machine& machine, const Pin& pin, std::size_t p) {
  const auto anchor = [&](const std::string& link) {
    return model::Vec3(machine.data->xpos + 3 * body_id(machine, link));
  };
  const model::Vec3 u = anchor(pin.link_b) - anchor(pin.link_a),
                    w = site(machine, p, 'a') - anchor(pin.link_a);
  return (u.z() * w.x() - u.x() * w.z()) * pin.branch > 0.0;
}

/// Closes every pin, from several starts, since a leg has two ways to close.
void close_pins(Machine& machine, const RobotFiles& files) {
  for (std::size_t p = 0; p < files.pins.size(); ++p) {
    const Pin& pin = files.pins[p];
    const JointPlace a = machine.joint(pin.joint_a), b = machine.joint(pin.joint_b);

    bool closed = false;
    for (const double guess : {0.5, 0.8, 0.2, 1.2, 2.0, -0.5, -1.0}) {
      machine.data->qpos[a.qpos] = machine.data->qpos[b.qpos] = guess;
      const double gap = close_pin(machine, p, a, b);
      closed = gap < 1e-12 && on_branch(machine, pin, p);
      if (closed) break;
    }

    if (!closed) {
      throw UnreachablePose(fmt::format(
          "start pose: the links '{}' and '{}' do not meet at their pin; allowed: motor angles "
          "at which they do",
          pin.link_a, pin.link_b));
    }
  }
}

/// Lowest point of toe i above the floor [m].
double toe_height(const Machine& machine, std::size_t i) {
  const int id = machine.toes[i];
  return machine.data->geom_xpos[3 * id + 2] - machine.model->geom_size[3 * id];
}

void stand(Machine& machine, const RobotFiles& files, const StartPose& pose) {
  mjData& d = *machine.data;
  if (machine.toes.empty()) {
    d.qpos[machine.base_z.qpos] = std::isnan(pose.z) ? 0.0 : pose.z;
    return;
  }

  for (int i = 0; i < 50; ++i) {
    kinematics(machine);
    // x and height of the lowest toe of each foot's name
    std::map<std::string, std::pair<double, double>> ends;
    for (std::size_t t = 0; t < machine.toes.size(); ++t) {
      const double h = toe_height(machine, t), x = d.geom_xpos[3 * machine.toes[t]];
      const auto [found, added] = ends.emplace(files.toes[t].name, std::make_pair(x, h));
      if (!added && h < found->second.second) found->second = {x, h};
    }
    double lowest = kInfinity;
    for (const auto& [name, end] : ends) lowest = std::min(lowest, end.second);
    d.qpos[machine.base_z.qpos] -= lowest;
    if (!pose.level || ends.size() != 2) break;
    const auto [x1, h1] = ends.begin()->second;
    const auto [x2, h2] = std::next(ends.begin())->second;
    const double turn = std::atan2(h1 - h2, x1 - x2);  // positive pitch lowers what is ahead
    if (std::abs(turn) < 1e-12) break;
    d.qpos[machine.base_pitch.qpos] += turn;
  }
}

/// Floor plates under the weight: shares of front and rear toes from the balance of moments about
/// the centre of mass.
void sink(Machine& machine) {
  const mjModel& m = *machine.model;
  mjData& d = *machine.data;
  const JointPlace first = machine.joint("plate_0");
  if (first.qpos < 0 || machine.base_z.qpos < 0) return;
  const double weight = m.body_subtreemass[machine.base] * std::abs(m.opt.gravity[2]);
  const double center = d.subtree_com[3 * machine.base];
  double sum = 0.0, square = 0.0;
  const auto n = static_cast<double>(machine.toes.size());
  for (const int toe : machine.toes) {
    const double x = d.geom_xpos[3 * toe] - center;
    sum += x;
    square += x * x;
  }

  // Loads a + b x with the sum the weight and no moment about the centre of mass: as a rigid body
  // loads equal springs. Toes at one place share alike.
  const double spread = n * square - sum * sum;
  const double b = spread > 1e-12 ? -weight * sum / spread : 0.0, a = (weight - b * sum) / n;
  double front = 0.0, rear = 0.0, front_x = -kInfinity, rear_x = kInfinity;
  for (std::size_t i = 0; i < machine.toes.size(); ++i) {
    const double x = d.geom_xpos[3 * machine.toes[i]];
    const int joint = mj_name2id(&m, mjOBJ_JOINT, fmt::format("plate_{}", i).c_str());
    const double depth = (a + b * (x - center)) / m.jnt_stiffness[joint];
    d.qpos[m.jnt_qposadr[joint]] = -depth;
    if (x > front_x) front_x = x, front = depth;
    if (x < rear_x) rear_x = x, rear = depth;
  }

  const double turn = front_x - rear_x > 1e-6 ? (front - rear) / (front_x - rear_x) : 0.0;
  d.qpos[machine.base_pitch.qpos] += std::atan(turn);
  d.qpos[machine.base_z.qpos] -= rear + turn * (d.qpos[machine.base_x.qpos] - rear_x);
}

}  // namespace

JointPlace Machine::joint(const std::string& name) const {
  const int id = mj_name2id(model.get(), mjOBJ_JOINT, name.c_str());
  if (id < 0) return {};
  return {model->jnt_qposadr[id], model->jnt_dofadr[id]};
}

Machine build_machine(const RobotFiles& files, const Changes& changes, const Setting& setting,
                      const Numerics& numerics) {
  Machine machine;
  machine.model = compile(mjcf(files, changes, setting, numerics));
  machine.data.reset(mj_makeData(machine.model.get()));
  mjModel& m = *machine.model;
  for (std::size_t i = 0; i < files.pins.size(); ++i) {
    // The compiler takes the second anchor from where the bodies are at zero, where a leg need not
    // be closed.
    double* anchors = m.eq_data + mjNEQDATA * i;
    for (int k = 0; k < 3; ++k) anchors[3 + k] = files.pins[i].point_b[k];
  }

  machine.base_x = machine.joint("base_x");
  machine.base_z = machine.joint("base_z");
  machine.base_pitch = machine.joint("base_pitch");
  machine.base = body_id(machine, files.tree.links[files.tree.root].name);
  for (const Drive& drive : files.drives) machine.drives.push_back(machine.joint(drive.joint));
  for (std::size_t i = 0; i < files.toes.size(); ++i) {
    machine.toes.push_back(mj_name2id(&m, mjOBJ_GEOM, fmt::format("toe_{}", i).c_str()));
  }

  for (std::size_t i = 0; i < files.drags.size(); ++i) {
    machine.drag_pivot.push_back(body_id(machine, files.drag_links[i]));
    machine.strips.push_back(
        cut_strips(machine, files.drags[i], files.drag_links[i],
                   i == 0 ? shaft_hinges(files, changes) : std::vector<double>{}, numerics.strips));
  }
  return machine;
}

void place(Machine& machine, const RobotFiles& files, const StartPose& pose) {
  mjData& d = *machine.data;
  mj_resetData(machine.model.get(), &d);
  for (const auto& [name, value] : pose.joints) {
    if (const JointPlace own = machine.joint(name); own.qpos >= 0) d.qpos[own.qpos] = value;
    for (std::size_t i = 0; i < files.drives.size(); ++i) {
      if (files.drives[i].planar == name) d.qpos[machine.drives[i].qpos] = value;
    }
  }
  if (machine.base_x.qpos >= 0) {
    d.qpos[machine.base_x.qpos] = pose.x;
    d.qpos[machine.base_pitch.qpos] = pose.pitch;
    d.qpos[machine.base_z.qpos] = std::isnan(pose.z) ? 0.0 : pose.z;
  }
  kinematics(machine);
  close_pins(machine, files);
  if (machine.base_z.qpos >= 0 && std::isnan(pose.z)) stand(machine, files, pose);
  mj_forward(machine.model.get(), &d);
}

/// What pulls at a joint at rest where it stands at q; there it stays.
double pull_at(Machine& machine, int joint, double q) {
  const mjModel& m = *machine.model;
  mjData& d = *machine.data;
  d.qpos[m.jnt_qposadr[joint]] = q;
  kinematics(machine);
  mj_rne(&m, &d, 0, d.qfrc_bias);
  return -d.qfrc_bias[m.jnt_dofadr[joint]];
}

/// A play at the flank that its load rests on, or within where it hangs free of both.
void lean(Machine& machine, int joint) {
  double low = machine.model->jnt_range[2 * joint], high = machine.model->jnt_range[2 * joint + 1];
  if (pull_at(machine, joint, high) >= 0.0 || pull_at(machine, joint, low) <= 0.0) {
    const double pull = pull_at(machine, joint, 0.0);
    if (pull != 0.0) pull_at(machine, joint, pull > 0.0 ? high : low);
    return;
  }
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (pull_at(machine, joint, middle) > 0.0 ? low : high) = middle;
  }
}

void settle(Machine& machine) {
  const mjModel& m = *machine.model;
  mjData& d = *machine.data;
  for (int pass = 0; pass < 20; ++pass) {
    for (int j = 0; j < m.njnt; ++j)
      if (std::string(mj_id2name(&m, mjOBJ_JOINT, j)).ends_with("_play")) lean(machine, j);
    kinematics(machine);
    mj_rne(&m, &d, 0, d.qfrc_bias);
    for (int j = 0; j < m.njnt; ++j) {
      const std::string name = mj_id2name(&m, mjOBJ_JOINT, j);
      const double pull = -d.qfrc_bias[m.jnt_dofadr[j]];
      double& q = d.qpos[m.jnt_qposadr[j]];
      const bool sags = name.starts_with("tail_bend") || name == "sliding_load";
      if (sags) q = pull / m.jnt_stiffness[j];
    }
  }
  sink(machine);
  mj_forward(&m, &d);
}

}  // namespace jaculus::testbed

#endif  // JACULUS_HAS_MUJOCO
