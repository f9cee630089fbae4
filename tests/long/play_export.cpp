// Plays an exported plan in MuJoCo on the robot's own file, by the names of its joints, and says
// how far from the plan the robot is at its end. scripts/play_export runs it.
//
//   play_export PROBLEM.yaml SOLVE_FOLDER EXPORT.json
//
// What is played is the export alone: a controller at its rate that holds, from sample to sample,
//   torque + kp (position - measured) + kd (velocity - measured),
// at every joint that it names; joints that are to be held are, by stiff springs. Of the plan only
// the robot's first state and, to compare, its last one are taken. The robot is the file in the
// robot's folder: MuJoCo's bodies, its free base, left and right legs. What a file can't say comes
// from robot.yaml with the overrides of the problem: feet, pins that close loops, rotors, drag.
// Contact: feet are spheres of 2 mm on a plane, friction as robot.yaml has it.
//
// Prints one line of JSON: distance of the base [m] and pitch [rad] from the plan's end, what left
// the plane [m, rad], largest torque that PD added over the joint's largest planned torque [-].

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "jaculus/model/robot.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/transcription/problem.h"
#include "long/mujoco_file.h"

namespace {

namespace fs = std::filesystem;
using namespace jaculus;
using model::PlanarModel;
using Json = nlohmann::json;
using Mat3 = Eigen::Matrix3d;
using Vec3 = Eigen::Vector3d;
using Data = std::unique_ptr<mjData, void (*)(mjData*)>;

constexpr double kStep = 1e-4;        ///< of the integration [s]
constexpr double kFootRadius = 2e-3;  ///< [m]
constexpr double kStiffness = 0.2;  ///< PD makes a joint's largest planned torque at so much [rad]
constexpr double kDamping = 0.02;   ///< kd over kp [s]

/// Angle and place of every planar body, in the plane.
std::vector<Vec3> place_bodies(const PlanarModel& model, const Vec3& base,
                               const std::map<std::string, double>& angles) {
  std::vector<Vec3> places{base};
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const model::PlanarBody& body = model.bodies[b];
    const Vec3& p = places[static_cast<std::size_t>(body.parent)];
    const double theta = angles.at(body.joint);
    const Vec2 at = Eigen::Rotation2Dd(-p[2]) * (body.origin + body.axis * theta);
    const bool turns = body.kind == model::JointKind::revolute;
    places.emplace_back(p[0] + at.x(), p[1] + at.y(),
                        p[2] + body.angle_offset + (turns ? body.sign * theta : 0.0));
  }
  return places;
}

/// First state and last pose of the plan.
struct Ends {
  Vec3 first_base, last_base;           ///< x, z [m], pitch [rad]
  std::map<std::string, double> first;  ///< joints of the plan [rad or m]
};

Ends ends_of(const fs::path& solved, const PlanarModel& model) {
  const trajectory::Table plan = trajectory::read_csv(solved / "plan.csv");
  const Eigen::Index last = plan.values.rows() - 1;
  const auto column = [&](const std::string& name) {
    const int found = plan.column(name);
    if (found < 0) throw InputError("plan.csv has no column '" + name + "'");
    return found;
  };

  Ends ends;
  const std::array<const char*, 3> base{"x", "z", "pitch"};
  for (int i = 0; i < 3; ++i) {
    const int at = column(base[static_cast<std::size_t>(i)]);
    ends.first_base[i] = plan.values(0, at);
    ends.last_base[i] = plan.values(last, at);
  }
  for (int b = 1; b < count_of(model.bodies); ++b) {
    const std::string& joint = model.bodies[static_cast<std::size_t>(b)].joint;
    const int at = plan.column(joint);  // a locked joint has none
    ends.first[joint] = at >= 0 ? plan.values(0, at) : model.joint_offset[b];
  }
  return ends;
}

/// A point on one side of a planar body, on MuJoCo's body.
struct BodyPoint {
  int body = 0;
  Vec3 at = Vec3::Zero();  ///< in its frame [m]
};

/// The robot's file on a free base, with feet, floor and pins.
class Robot {
 public:
  Robot(const PlanarModel& planar, const fs::path& file, const Ends& ends)
      : planar_(planar), model_(test::load_mujoco(file)), data_(nullptr, mj_deleteData) {
    text_ = as_mjcf();
    insert_after("<body name=\"" + root_ + "\"", "<freejoint/>");
    load();
    set_state(ends);
    add_contact(ends);
    const std::vector<std::array<BodyPoint, 2>> pins = add_pins(ends);
    load();
    for (std::size_t i = 0; i < pins.size(); ++i) {
      for (std::size_t side = 0; side < 2; ++side)
        std::copy(pins[i][side].at.data(), pins[i][side].at.data() + 3,
                  model_->eq_data + mjNEQDATA * i + 3 * side);
    }
    settle();
    set_state(ends);
  }

  [[nodiscard]] mjModel& model() { return *model_; }
  [[nodiscard]] mjData& data() { return *data_; }

  [[nodiscard]] int joint(const std::string& name) const {
    const int j = mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str());
    if (j < 0) throw InputError("the robot's file has no joint '" + name + "'");
    return j;
  }

  /// x, z [m] and pitch [rad] of the base; y [m] and the angle that its axis leans [rad].
  [[nodiscard]] Vec3 base() const {
    const Mat3 R = rotation(root_body());
    const double* p = data_->xpos + 3 * root_body();
    return {p[0], p[2], std::atan2(R(0, 2), R(0, 0))};
  }
  [[nodiscard]] std::array<double, 2> out_of_plane() const {
    return {data_->xpos[3 * root_body() + 1],
            std::acos(std::clamp(rotation(root_body())(1, 1), -1.0, 1.0))};
  }

  [[nodiscard]] Mat3 rotation(int body) const {
    using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    return Eigen::Map<const Rows>(data_->xmat + 9 * body);
  }

  /// The bodies of MuJoCo that a planar body stands for, left first; the base's is the root.
  [[nodiscard]] std::vector<int> sides(int body) const {
    if (body == 0) return {root_body()};
    std::vector<int> found;
    for (const model::FileJoint& side : planar_.bodies[static_cast<std::size_t>(body)].file_joints)
      found.push_back(model_->jnt_bodyid[joint(side.name)]);
    return found;
  }

  /// A point of a planar body on MuJoCo's body, while both are in the state of `ends`.
  [[nodiscard]] BodyPoint point(int body, int side, const Vec2& at, const Ends& ends) const {
    const Vec3 place =
        place_bodies(planar_, ends.first_base, ends.first)[static_cast<std::size_t>(body)];
    const Vec2 p = place.head<2>() + Eigen::Rotation2Dd(-place[2]) * at;
    const double* origin = data_->xpos + 3 * side;
    return {side, rotation(side).transpose() *
                      (Vec3(p.x(), origin[1], p.y()) - Vec3(origin[0], origin[1], origin[2]))};
  }

 private:
  [[nodiscard]] int root_body() const { return 1; }

  /// What was read, as MuJoCo writes it.
  std::string as_mjcf() {
    root_ = mj_id2name(model_.get(), mjOBJ_BODY, 1);
    const fs::path file = fs::temp_directory_path() / fmt::format("play_export_{}.xml", ::getpid());
    std::array<char, 1000> error{};
    if (mj_saveLastXML(file.c_str(), model_.get(), error.data(), 1000) == 0)
      throw InputError(fmt::format("MuJoCo can't write what it read: {}", error.data()));
    const std::string text = read_text_file(file, "MJCF");
    fs::remove(file);
    return text;
  }

  void insert_after(const std::string& tag, const std::string& more) {
    const std::size_t at = text_.find(tag);
    if (at == std::string::npos) throw InputError("MuJoCo's file has no " + tag);
    text_.insert(text_.find('>', at) + 1, more);
  }

  void load() {
    model_ = test::load_mujoco_text(text_);
    data_.reset(mj_makeData(model_.get()));
  }

  void set_state(const Ends& ends) {
    mj_resetData(model_.get(), data_.get());
    const Eigen::Quaterniond q(Eigen::AngleAxisd(ends.first_base[2], Vec3::UnitY()));
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

  void add_contact(const Ends& ends) {
    for (const model::PlanarPoint& foot : planar_.feet) {
      for (const int side : sides(foot.body)) {
        const BodyPoint p = point(foot.body, side, foot.position, ends);
        insert_after(
            fmt::format("<body name=\"{}\"", mj_id2name(model_.get(), mjOBJ_BODY, side)),
            fmt::format("<geom name=\"foot_of_play_{}_{}\" type=\"sphere\" size=\"{}\" mass=\"0\" "
                        "pos=\"{} {} {}\"/>",
                        foot.name, side, kFootRadius, p.at.x(), p.at.y(), p.at.z()));
      }
    }
    insert_after("<worldbody", fmt::format("<geom name=\"floor_of_play\" type=\"plane\" "
                                           "size=\"0 0 1\" pos=\"0 0 {}\"/>",
                                           -kFootRadius));
  }

  /// One equality a pin and side; where its ends are is set after loading, for MuJoCo would take
  /// them from its zero, at which loops are open.
  std::vector<std::array<BodyPoint, 2>> add_pins(const Ends& ends) {
    std::vector<std::array<BodyPoint, 2>> pins;
    std::string equalities;
    for (const model::PlanarLoop& loop : planar_.loops) {
      const std::vector<int> a = sides(loop.body_a), b = sides(loop.body_b);
      for (std::size_t side = 0; side < std::min(a.size(), b.size()); ++side) {
        pins.push_back({point(loop.body_a, a[side], loop.point_a, ends),
                        point(loop.body_b, b[side], loop.point_b, ends)});
        equalities += fmt::format("<connect body1=\"{}\" body2=\"{}\" anchor=\"0 0 0\"/>",
                                  mj_id2name(model_.get(), mjOBJ_BODY, a[side]),
                                  mj_id2name(model_.get(), mjOBJ_BODY, b[side]));
      }
    }
    if (!pins.empty())
      text_.insert(text_.rfind("</mujoco>"), "<equality>" + equalities + "</equality>");
    return pins;
  }

  /// Stiff contact and pins, rotors, and nothing that touches but feet and floor.
  void settle() {
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
    for (const model::PlanarMotor& motor : planar_.motors) {
      const auto& body = planar_.bodies[static_cast<std::size_t>(motor.body)];
      for (const model::FileJoint& side : body.file_joints)
        m.dof_armature[m.jnt_dofadr[joint(side.name)]] +=
            motor.gear * motor.gear * motor.rotor_inertia;
    }
  }

  const PlanarModel& planar_;
  test::MujocoModel model_;
  Data data_;
  std::string root_, text_;
};

/// One joint of the export.
struct Played {
  int q = 0, v = 0;  ///< places in qpos and qvel
  double zero = 0.0;
  std::vector<double> position, velocity, torque;
  double kp = 0.0;
};

std::vector<Played> read_export(const Json& json, const Robot& robot, const mjModel& m) {
  std::vector<Played> joints;
  for (const Json& joint : json.at("joints")) {
    const int j = robot.joint(joint.at("name").get<std::string>());
    Played& p = joints.emplace_back();
    p.q = m.jnt_qposadr[j];
    p.v = m.jnt_dofadr[j];
    p.zero = m.qpos0[p.q];
    p.position = joint.at("position").get<std::vector<double>>();
    p.velocity = joint.at("velocity").get<std::vector<double>>();
    p.torque = joint.at("torque").get<std::vector<double>>();
    double peak = 0.0;
    for (const double tau : p.torque) peak = std::max(peak, std::abs(tau));
    p.kp = peak / kStiffness;
  }
  return joints;
}

/// Joints that are to be held are, by springs with damping that MuJoCo integrates implicitly.
void hold_joints(const Json& json, const Robot& robot, double stiffest, mjModel& m) {
  for (const Json& joint : json.at("held_joints")) {
    const int j = robot.joint(joint.at("name").get<std::string>());
    const int q = m.jnt_qposadr[j];
    m.qpos_spring[q] = m.qpos0[q] + joint.at("position").get<double>();
    m.jnt_stiffness[j] = 100.0 * stiffest;
    m.dof_damping[m.jnt_dofadr[j]] = kDamping * m.jnt_stiffness[j];
  }
}

/// Drag of the plan's model on the file's bodies, as one force for each strip of the tail.
void add_drag(const PlanarModel& planar, Robot& robot) {
  constexpr int kStrips = 40;
  mjData& d = robot.data();
  for (const model::PlanarDrag& drag : planar.drags) {
    if (drag.kind == model::DragKind::none || drag.coefficient == 0.0) continue;
    if (drag.kind == model::DragKind::rotation)
      throw InputError("drag of kind rotation isn't played; allowed: distributed, point, none");
    const bool at_point = drag.kind == model::DragKind::point;
    for (const int body : robot.sides(drag.body)) {
      for (int k = 0; k < (at_point ? 1 : kStrips); ++k) {
        const double strip = (drag.end - drag.start) / kStrips;
        const double s = at_point ? drag.point_distance : drag.start + (k + 0.5) * strip;
        const double area = at_point ? drag.point_area : drag.width * strip;
        const Mat3 R = robot.rotation(body);
        const Vec3 along = R * Vec3(drag.direction.x(), 0.0, drag.direction.y());
        const Vec3 normal = Vec3::UnitY().cross(along).normalized();
        const Vec3 p = Eigen::Map<const Vec3>(d.xpos + 3 * body) + s * along;
        std::array<double, 6> velocity{};
        mj_objectVelocity(&robot.model(), &d, mjOBJ_XBODY, body, velocity.data(), 0);
        const Vec3 omega(velocity[0], velocity[1], velocity[2]);
        const Vec3 v = Vec3(velocity[3], velocity[4], velocity[5]) +
                       omega.cross(p - Eigen::Map<const Vec3>(d.xpos + 3 * body));
        const double vn = v.dot(normal);
        const Vec3 force =
            -0.5 * drag.density * drag.coefficient * area * std::abs(vn) * vn * normal;
        const Vec3 none = Vec3::Zero();
        mj_applyFT(&robot.model(), &d, force.data(), none.data(), p.data(), body, d.qfrc_applied);
      }
    }
  }
}

Json play(const PlanarModel& planar, const Ends& ends, const Json& exported, Robot& robot) {
  mjModel& m = robot.model();
  mjData& d = robot.data();
  const std::vector<Played> joints = read_export(exported, robot, m);
  double stiffest = 0.0;
  for (const Played& p : joints) stiffest = std::max(stiffest, p.kp);
  hold_joints(exported, robot, stiffest, m);

  const double rate = exported.at("rate_hz").get<double>();
  const double duration = exported.at("duration_s").get<double>();
  const std::size_t samples = exported.at("time_s").size();

  std::vector<double> command(joints.size(), 0.0);
  double added = 0.0;
  std::size_t next = 0;
  while (d.time < duration - 1e-9) {
    if (next < samples && d.time >= static_cast<double>(next) / rate - 1e-9) {
      for (std::size_t j = 0; j < joints.size(); ++j) {
        const Played& p = joints[j];
        const double pd = p.kp * (p.position[next] - (d.qpos[p.q] - p.zero)) +
                          kDamping * p.kp * (p.velocity[next] - d.qvel[p.v]);
        command[j] = p.torque[next] + pd;
        if (p.kp > 0.0) added = std::max(added, std::abs(pd) / (p.kp * kStiffness));
      }
      ++next;
    }

    mju_zero(d.qfrc_applied, m.nv);
    for (std::size_t j = 0; j < joints.size(); ++j) d.qfrc_applied[joints[j].v] = command[j];
    add_drag(planar, robot);
    m.opt.timestep = std::min(kStep, duration - d.time);
    mj_step(&m, &d);
    if (d.warning[mjWARN_BADQACC].number + d.warning[mjWARN_BADQPOS].number > 0)
      throw InputError("MuJoCo's simulation went unstable: PD too stiff for the rate");
  }

  mj_kinematics(&m, &d);
  const Vec3 off = robot.base() - ends.last_base;
  const auto [sideways, lean] = robot.out_of_plane();
  return {{"distance_m", off.head<2>().norm()},
          {"pitch_rad", std::abs(off[2])},
          {"sideways_m", std::abs(sideways)},
          {"lean_rad", lean},
          {"pd_share", added},
          {"joints", joints.size()},
          {"travelled_m", (ends.last_base - ends.first_base).head<2>().norm()}};
}

Json run(const fs::path& problem_file, const fs::path& solved, const fs::path& export_file) {
  const transcription::Problem problem = transcription::read_problem(problem_file);
  const model::Robot read = model::read_robot(problem.robot_folder, problem.overrides);
  const PlanarModel planar = transcription::planning_model(problem, read.planar);
  std::ifstream in(export_file);
  const Json exported = Json::parse(in);
  if (exported.at("format") != "jaculus-export/2" || exported.at("side") != "joint" ||
      !exported.at("joints_of_robot_file").get<bool>())
    throw InputError(export_file.string() + ": allowed: `export --as json` of joints of the file");

  const Ends ends = ends_of(solved, planar);
  Robot robot(planar, problem.robot_folder / "robot.urdf", ends);
  return play(planar, ends, exported, robot);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "usage: play_export PROBLEM.yaml SOLVE_FOLDER EXPORT.json\n");
    return 2;
  }
  try {
    fmt::print("{}\n", run(argv[1], argv[2], argv[3]).dump());
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
