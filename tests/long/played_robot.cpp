#include "long/played_robot.h"

#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>

#include "jaculus/transcription/layout.h"
#include "long/planar_pose.h"
#include "model/sections.h"

namespace jaculus::test {
namespace {

namespace fs = std::filesystem;
using Mat3 = Eigen::Matrix3d;
using Vec3 = Eigen::Vector3d;

constexpr double kFootRadius = 2e-3;  ///< [m]
constexpr int kRoot = 1;              ///< MuJoCo's body of the base; 0 is the world

std::string numbers(const Vec3& v) { return fmt::format("{} {} {}", v.x(), v.y(), v.z()); }

/// A link that is attached, with the joint that carries it and all that hang on it, as MJCF.
std::string body_text(const model::SpatialTree& tree, int index) {
  const model::SpatialLink& link = tree.links[static_cast<std::size_t>(index)];
  const model::SpatialJoint& joint = tree.joints[static_cast<std::size_t>(link.joint)];
  const Eigen::Quaterniond q(joint.rotation);
  std::string text = fmt::format("<body name=\"{}\" pos=\"{}\" quat=\"{} {} {} {}\">", link.name,
                                 numbers(joint.origin), q.w(), q.x(), q.y(), q.z());
  if (joint.kind != model::SpatialJointKind::fixed) {
    const bool slides = joint.kind == model::SpatialJointKind::prismatic;
    text += fmt::format("<joint name=\"{}\" type=\"{}\" axis=\"{}\"/>", joint.name,
                        slides ? "slide" : "hinge", numbers(joint.axis));
  }
  if (link.mass > 0.0) {
    const Mat3& I = link.inertia;
    text += fmt::format("<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>",
                        numbers(link.com), link.mass, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2),
                        I(1, 2));
  }

  for (const model::SpatialJoint& next : tree.joints)
    if (next.parent == index) text += body_text(tree, next.child);
  return text + "</body>";
}

}  // namespace

model::PlanarModel played_model(const transcription::Problem& problem,
                                const model::PlanarModel& model) {
  transcription::Problem unlimited = problem;
  unlimited.friction = unlimited.voltage = unlimited.torque = unlimited.force = unlimited.current =
      std::nullopt;
  return transcription::planning_model(unlimited, model);
}

double planned_limit(const transcription::Problem& problem, const model::PlanarModel& model,
                     const std::string& joint) {
  for (const model::PlanarMotor& motor : model.motors) {
    const auto& sides = model.bodies[static_cast<std::size_t>(motor.body)].file_joints;
    const bool drives = std::any_of(sides.begin(), sides.end(),
                                    [&](const auto& side) { return side.name == joint; });
    if (drives) return transcription::usable_torque(problem, model, motor);
  }
  return kInfinity;
}

model::SpatialTree played_tree(const model::Robot& robot,
                               const std::vector<model::Override>& overrides) {
  model::SpatialTree tree = model::read_tree(robot.folder, overrides);
  const fs::path stated = robot.folder / "robot.yaml";
  if (!fs::exists(stated)) return tree;
  std::vector<std::string> notes;
  const model::SpatialTree placed =
      model::read_placement(yaml::Node::load(stated), model::read_urdf(robot.urdf), notes);
  tree.links[static_cast<std::size_t>(tree.root)].R_BL =
      placed.links[static_cast<std::size_t>(placed.root)].R_BL;
  return tree;
}

BodiesFile::BodiesFile(const model::Robot& robot) : path_(robot.urdf) {
  const fs::path stated = robot.folder / "robot.yaml";
  if (!fs::exists(stated)) return;
  const auto base = yaml::Node::load(stated).find("base_link");
  if (!base) return;
  const model::SpatialTree whole = model::read_urdf(robot.urdf);
  path_ = fs::temp_directory_path() / fmt::format("play_export_{}.urdf", ::getpid());
  own_ = true;
  std::ofstream(path_) << model::write_urdf(model::subtree(whole, whole.link_index(base->text())));
}

BodiesFile::~BodiesFile() {
  std::error_code code;
  if (own_) fs::remove(path_, code);
}

PlayedRobot::PlayedRobot(const model::PlanarModel& planar, const fs::path& file,
                         const model::SpatialTree& tree, const Ends& ends)
    : planar_(planar),
      axes_(tree.links[static_cast<std::size_t>(tree.root)].R_BL),
      model_(load_mujoco(file)),
      data_(nullptr, mj_deleteData) {
  text_ = as_mjcf();
  insert_after("<body name=\"" + name_of(kRoot) + "\"", "<freejoint/>");
  add_attached(tree);
  load();
  set_state(ends);
  add_contact(ends);
  const std::vector<std::array<Vec3, 2>> pins = add_pins(ends);
  load();
  for (std::size_t i = 0; i < pins.size(); ++i) {
    for (std::size_t side = 0; side < 2; ++side)
      std::copy(pins[i][side].data(), pins[i][side].data() + 3,
                model_->eq_data + mjNEQDATA * i + 3 * side);
  }
  settle();
  set_state(ends);
}

int PlayedRobot::joint(const std::string& name) const {
  const int j = mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str());
  if (j < 0)
    throw InputError("neither the robot's file nor what is attached has a joint '" + name + "'");
  return j;
}

Vec3 PlayedRobot::base() const {
  const Mat3 R = rotation(kRoot) * axes_.transpose();
  const double* p = data_->xpos + 3 * kRoot;
  return {p[0], p[2], std::atan2(R(0, 2), R(0, 0))};
}

std::array<double, 2> PlayedRobot::out_of_plane() const {
  const Mat3 R = rotation(kRoot) * axes_.transpose();
  return {data_->xpos[3 * kRoot + 1], std::acos(std::clamp(R(1, 1), -1.0, 1.0))};
}

Mat3 PlayedRobot::rotation(int body) const {
  using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  return Eigen::Map<const Rows>(data_->xmat + 9 * body);
}

std::vector<int> PlayedRobot::sides(int body) const {
  if (body == 0) return {kRoot};
  std::vector<int> found;
  for (const model::FileJoint& side : planar_.bodies[static_cast<std::size_t>(body)].file_joints)
    found.push_back(model_->jnt_bodyid[joint(side.name)]);
  return found;
}

/// Where a point of a planar body is in space, while both are in the state of `ends`: from the
/// side's origin in the plane that it turns in, which leans where its axis does.
Vec3 PlayedRobot::in_space(int body, int side, const Vec2& at, const Ends& ends) const {
  const Vec3 place =
      place_bodies(planar_, ends.first_base, ends.first)[static_cast<std::size_t>(body)];
  const Vec2 way = Eigen::Rotation2Dd(-place[2]) * at;
  Vec3 normal = Vec3::UnitY();
  const int j = model_->body_jntadr[side];
  if (j >= 0 && model_->jnt_type[j] == mjJNT_HINGE)
    normal = Eigen::Map<const Vec3>(data_->xaxis + 3 * j);
  const double out = (way.x() * normal.x() + way.y() * normal.z()) / normal.y();
  return Eigen::Map<const Vec3>(data_->xpos + 3 * side) + Vec3(way.x(), -out, way.y());
}

Vec3 PlayedRobot::in_frame(int side, const Vec3& point) const {
  return rotation(side).transpose() * (point - Eigen::Map<const Vec3>(data_->xpos + 3 * side));
}

/// What was read, as MuJoCo writes it.
std::string PlayedRobot::as_mjcf() {
  const fs::path file = fs::temp_directory_path() / fmt::format("play_export_{}.xml", ::getpid());
  std::array<char, 1000> error{};
  if (mj_saveLastXML(file.c_str(), model_.get(), error.data(), 1000) == 0)
    throw InputError(fmt::format("MuJoCo can't write what it read: {}", error.data()));
  const std::string text = read_text_file(file, "MJCF");
  fs::remove(file);
  return text;
}

std::string PlayedRobot::name_of(int body) const {
  return mj_id2name(model_.get(), mjOBJ_BODY, body);
}

void PlayedRobot::insert_after(const std::string& tag, const std::string& more) {
  const std::size_t at = text_.find(tag);
  if (at == std::string::npos) throw InputError("MuJoCo's file has no " + tag);
  text_.insert(text_.find('>', at) + 1, more);
}

void PlayedRobot::load() {
  model_ = load_mujoco_text(text_);
  data_.reset(mj_makeData(model_.get()));
}

void PlayedRobot::set_state(const Ends& ends) {
  mj_resetData(model_.get(), data_.get());
  const Eigen::AngleAxisd pitch(ends.first_base[2], Vec3::UnitY());
  const Eigen::Quaterniond q(Mat3(pitch * axes_));
  const std::array<double, 7> pose{
      ends.first_base[0], 0.0, ends.first_base[1], q.w(), q.x(), q.y(), q.z()};
  std::copy(pose.begin(), pose.end(), data_->qpos);
  for (const model::PlanarBody& body : planar_.bodies) {
    for (const model::FileJoint& side : body.file_joints) {
      const int at = model_->jnt_qposadr[joint(side.name)];
      data_->qpos[at] = model_->qpos0[at] + side.sign * ends.first.at(body.joint);
    }
  }
  for (const model::HeldJoint& held : planar_.held) {
    const int at = model_->jnt_qposadr[joint(held.joint)];
    data_->qpos[at] = model_->qpos0[at] + held.value;
  }
  mj_kinematics(model_.get(), data_.get());
}

/// What robot.yaml attaches; MuJoCo balances rods whose moments rounding leaves out of a triangle.
void PlayedRobot::add_attached(const model::SpatialTree& tree) {
  insert_after("<mujoco",
               "<compiler balanceinertia=\"true\" boundmass=\"1e-12\" boundinertia=\"1e-14\"/>");
  for (const model::SpatialJoint& joint : tree.joints) {
    const model::SpatialLink& parent = tree.links[static_cast<std::size_t>(joint.parent)];
    const bool on_attached =
        parent.joint >= 0 && tree.joints[static_cast<std::size_t>(parent.joint)].attached;
    if (!joint.attached || on_attached) continue;
    const std::string name = parent.name == "world" ? "jaculus_world" : parent.name;
    insert_after("<body name=\"" + name + "\"", body_text(tree, joint.child));
  }
}

/// The floor is as far below the feet as in the plan: a leg that leans reaches the same place of
/// the plane from a hip a little higher or lower.
void PlayedRobot::add_contact(const Ends& ends) {
  const std::vector<Vec3> places = place_bodies(planar_, ends.first_base, ends.first);
  double floor = kInfinity;
  for (const model::PlanarPoint& foot : planar_.feet) {
    const Vec3& place = places[static_cast<std::size_t>(foot.body)];
    const double planned = place.y() + (Eigen::Rotation2Dd(-place[2]) * foot.position).y();
    for (const int side : sides(foot.body)) {
      const Vec3 at = in_space(foot.body, side, foot.position, ends);
      const Vec3 p = in_frame(side, at);
      floor = std::min(floor, at.z() - planned);
      insert_after(
          fmt::format("<body name=\"{}\"", name_of(side)),
          fmt::format("<geom name=\"foot_of_play_{}_{}\" type=\"sphere\" size=\"{}\" mass=\"0\" "
                      "pos=\"{} {} {}\"/>",
                      foot.name, side, kFootRadius, p.x(), p.y(), p.z()));
    }
  }
  insert_after("<worldbody", fmt::format("<geom name=\"floor_of_play\" type=\"plane\" "
                                         "size=\"0 0 1\" pos=\"0 0 {}\"/>",
                                         (planar_.feet.empty() ? 0.0 : floor) - kFootRadius));
}

/// One equality a pin and side; where its ends are is set after loading, for MuJoCo would take
/// them from its zero, at which loops are open. It holds the ends together sideways too, which no
/// joint of the plane can give way to: links that lie side by side have them midway on the pin.
std::vector<std::array<Vec3, 2>> PlayedRobot::add_pins(const Ends& ends) {
  std::vector<std::array<Vec3, 2>> pins;
  std::string equalities;
  for (const model::PlanarLoop& loop : planar_.loops) {
    const std::vector<int> a = sides(loop.body_a), b = sides(loop.body_b);
    for (std::size_t side = 0; side < std::min(a.size(), b.size()); ++side) {
      const Vec3 pin = 0.5 * (in_space(loop.body_a, a[side], loop.point_a, ends) +
                              in_space(loop.body_b, b[side], loop.point_b, ends));
      pins.push_back({in_frame(a[side], pin), in_frame(b[side], pin)});
      equalities += fmt::format("<connect body1=\"{}\" body2=\"{}\" anchor=\"0 0 0\"/>",
                                name_of(a[side]), name_of(b[side]));
    }
  }
  if (!pins.empty())
    text_.insert(text_.rfind("</mujoco>"), "<equality>" + equalities + "</equality>");
  return pins;
}

/// Stiff contact and pins, and nothing that touches but feet and floor.
void PlayedRobot::settle() {
  mjModel& m = *model_;
  m.opt.timestep = kStep;
  m.opt.cone = mjCONE_ELLIPTIC;
  m.opt.impratio = 100.0;
  m.opt.iterations = 200;
  m.opt.gravity[0] = m.opt.gravity[1] = 0.0;
  m.opt.gravity[2] = -planar_.gravity;

  for (int g = 0; g < m.ngeom; ++g) {
    const char* name = mj_id2name(&m, mjOBJ_GEOM, g);
    const bool ours = name != nullptr && std::string(name).find("_of_play") != std::string::npos;
    m.geom_contype[g] = m.geom_conaffinity[g] = 0;
    if (!ours) continue;
    const bool floor = std::string(name).starts_with("floor");
    m.geom_contype[g] = floor ? 1 : 2;
    m.geom_conaffinity[g] = floor ? 2 : 1;
    m.geom_friction[3 * g] = planar_.friction;
    m.geom_solref[2 * g] = 10.0 * kStep;
  }
  for (int e = 0; e < m.neq; ++e) m.eq_solref[2 * e] = 10.0 * kStep;
  settle_motors();
}

/// Rotors and friction of the motors, on top of what the file says of its joints where the plan
/// knows nothing of that.
void PlayedRobot::settle_motors() {
  mjModel& m = *model_;
  for (const model::PlanarMotor& motor : planar_.motors) {
    const auto& body = planar_.bodies[static_cast<std::size_t>(motor.body)];
    for (const model::FileJoint& side : body.file_joints) {
      const int dof = m.jnt_dofadr[joint(side.name)];
      m.dof_armature[dof] += motor.gear * motor.gear * motor.rotor_inertia;
      if (motor.viscous_friction > 0.0) m.dof_damping[dof] = motor.viscous_friction;
      if (motor.dry_friction > 0.0) m.dof_frictionloss[dof] = motor.dry_friction;
    }
  }
}

void PlayedRobot::without(Part part) {
  constexpr double kGrip = 10.0;  // [-]: more than any leg pushes forward of what it presses
  mjModel& m = *model_;
  if (part == Part::contact)
    for (int g = 0; g < m.ngeom; ++g) m.geom_friction[3 * g] = kGrip;
  if (part == Part::armature) mju_zero(m.dof_armature, m.nv);
  if (part == Part::friction) {
    mju_zero(m.dof_damping, m.nv);
    mju_zero(m.dof_frictionloss, m.nv);
  }

  for (const model::PlanarMotor& motor : planar_.motors) {
    const auto& body = planar_.bodies[static_cast<std::size_t>(motor.body)];
    for (const model::FileJoint& side : body.file_joints) {
      const int dof = m.jnt_dofadr[joint(side.name)];
      if (part == Part::armature)
        m.dof_armature[dof] = motor.gear * motor.gear * motor.rotor_inertia;
      if (part == Part::friction) {
        m.dof_damping[dof] = motor.viscous_friction;
        m.dof_frictionloss[dof] = motor.dry_friction;
      }
    }
  }
}

}  // namespace jaculus::test
