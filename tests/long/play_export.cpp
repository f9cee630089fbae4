// Plays an exported plan in MuJoCo on the robot's own file, by the names of its joints, and says
// how far from the plan the robot is at its end. scripts/play_export runs it.
//
//   play_export PROBLEM.yaml SOLVE_FOLDER EXPORT.json [PATH=VALUE ...]
//
// What is played is the export alone: a controller at its rate that holds, from sample to sample,
//   torque + kp (position - measured) + kd (velocity - measured),
// at every joint that it names; joints that are to be held are, by stiff springs. Of the plan only
// the robot's first state and, to compare, its last one are taken; air acts as in its model. Robot
// and floor are as robot.yaml has them, not as the plan's limits (played_robot.h); torques are held
// against the limits of the problem. PATH=VALUE: overrides that the plan was solved with.
//
// Prints one line of JSON: distance of the base [m] and pitch [rad] from the plan's end, what left
// the plane [m, rad], largest torque that PD added over the joint's largest planned torque [-], the
// largest torque over the limit of the problem, or its motor's own [-], and the floor's friction.
// Exit 0; 1 where the robot ends 1 cm or 2 deg or more from the plan: the JSON then has under
// `without` how far off it ends freed of one part each (friction and armature of joints beyond
// those of the plan's model, feet that slip) or with torques held within the limits, and standard
// error says which of these it is; 2 where it can't be played.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "jaculus/components/motor.h"
#include "jaculus/core/angle.h"
#include "jaculus/model/robot.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/transcription/problem.h"
#include "long/played_robot.h"

namespace {

namespace fs = std::filesystem;
using namespace jaculus;
using model::PlanarModel;
using Json = nlohmann::json;
using test::Ends;
using test::Part;
using test::PlayedRobot;
using Mat3 = Eigen::Matrix3d;
using Vec3 = Eigen::Vector3d;

constexpr double kStiffness = 0.2;  ///< PD makes a joint's largest planned torque at so much [rad]
constexpr double kDamping = 0.02;   ///< kd over kp [s]
/// Held over a sample, kd takes at most so much of a joint's speed; at 2 it rings for ever [-].
constexpr double kBraking = 0.5;
constexpr double kFar = 0.01;               ///< of the base from the plan's end [m]
constexpr double kTurned = 2.0 / kDegrees;  ///< the same [rad]

/// What is played, on which robot.
struct Playing {
  const transcription::Problem& problem;
  const PlanarModel& planar;
  const model::SpatialTree& tree;
  std::filesystem::path file;
  Ends ends;
  Json exported;
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

/// One joint of the export.
struct Played {
  int q = 0, v = 0;  ///< places in qpos and qvel
  double zero = 0.0;
  std::vector<double> position, velocity, torque;
  double peak = 0.0;         ///< of the torque planned
  double limit = kInfinity;  ///< of the plan's torque, at the joint
  double kp = 0.0;
};

/// What each degree of freedom resists a torque with, all others free to follow [kg m^2 or kg].
Vector effective_inertias(PlayedRobot& robot) {
  const mjModel& m = robot.model();
  mj_forward(&m, &robot.data());
  Matrix M(m.nv, m.nv);
  mj_fullM(&m, M.data(), robot.data().qM);  // symmetric, so the order of its cells is no matter
  return M.inverse().diagonal().cwiseInverse();
}

std::vector<Played> read_export(const Playing& playing, PlayedRobot& robot) {
  const Json& json = playing.exported;
  const mjModel& m = robot.model();
  const Vector inertias = effective_inertias(robot);
  const double rate = json.at("rate_hz").get<double>();
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
    p.limit =
        test::planned_limit(playing.problem, playing.planar, joint.at("name").get<std::string>());

    for (const double tau : p.torque) p.peak = std::max(p.peak, std::abs(tau));
    p.kp = std::min(p.peak / kStiffness, kBraking * inertias[p.v] * rate / kDamping);
  }
  return joints;
}

/// Joints that are to be held are, by springs with damping that MuJoCo integrates implicitly.
void hold_joints(const Json& json, const PlayedRobot& robot, double stiffest, mjModel& m) {
  for (const Json& joint : json.at("held_joints")) {
    const int j = robot.joint(joint.at("name").get<std::string>());
    const int q = m.jnt_qposadr[j];
    m.qpos_spring[q] = m.qpos0[q] + joint.at("position").get<double>();
    m.jnt_stiffness[j] = 100.0 * stiffest;
    m.dof_damping[m.jnt_dofadr[j]] = kDamping * m.jnt_stiffness[j];
  }
}

/// Drag of the plan's model on the file's bodies, as one force for each strip of the tail.
void add_drag(const PlanarModel& planar, PlayedRobot& robot) {
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

/// `limited`: motors give no more than their largest torque.
Json play(const Playing& playing, Part freed_of, bool limited) {
  const auto& [problem, planar, tree, file, ends, exported] = playing;
  PlayedRobot robot(planar, file, tree, ends);
  robot.without(freed_of);
  mjModel& m = robot.model();
  mjData& d = robot.data();
  const std::vector<Played> joints = read_export(playing, robot);
  double stiffest = 0.0;
  for (const Played& p : joints) stiffest = std::max(stiffest, p.peak / kStiffness);
  hold_joints(exported, robot, stiffest, m);

  const double rate = exported.at("rate_hz").get<double>();
  const double duration = exported.at("duration_s").get<double>();
  const std::size_t samples = exported.at("time_s").size();

  std::vector<double> command(joints.size(), 0.0);
  double added = 0.0, of_limit = 0.0;
  std::size_t next = 0;
  while (d.time < duration - 1e-9) {
    if (next < samples && d.time >= static_cast<double>(next) / rate - 1e-9) {
      for (std::size_t j = 0; j < joints.size(); ++j) {
        const Played& p = joints[j];
        const double pd = p.kp * (p.position[next] - (d.qpos[p.q] - p.zero)) +
                          kDamping * p.kp * (p.velocity[next] - d.qvel[p.v]);
        command[j] = p.torque[next] + pd;
        of_limit = std::max(of_limit, std::abs(command[j]) / p.limit);
        if (limited) command[j] = std::clamp(command[j], -p.limit, p.limit);
        if (p.peak > 0.0) added = std::max(added, std::abs(pd) / p.peak);
      }
      ++next;
    }

    mju_zero(d.qfrc_applied, m.nv);
    for (std::size_t j = 0; j < joints.size(); ++j) d.qfrc_applied[joints[j].v] = command[j];
    add_drag(planar, robot);
    m.opt.timestep = std::min(PlayedRobot::kStep, duration - d.time);
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
          {"limit_share", of_limit},
          {"joints", joints.size()},
          {"friction", planar.friction},
          {"travelled_m", (ends.last_base - ends.first_base).head<2>().norm()}};
}

bool is_far(const Json& played) {
  return !(played["distance_m"].get<double>() < kFar &&
           played["pitch_rad"].get<double>() < kTurned);
}

/// How far off the robot ends freed of one part at a time.
Json parts(const Playing& playing) {
  Json without;
  const auto add = [&](const char* name, Part part, bool limited) {
    const Json played = play(playing, part, limited);
    without[name] = {{"distance_m", played["distance_m"]}, {"pitch_rad", played["pitch_rad"]}};
  };
  add("friction of joints that the plan's model lacks", Part::friction, false);
  add("armature of joints that the plan's model lacks", Part::armature, false);
  add("slip of feet", Part::contact, false);
  add("torques beyond the motors' limits", Part::none, true);
  return without;
}

/// For people, on standard error.
void explain(const Json& played) {
  const auto distance = [](const Json& of) {
    return fmt::format("{:.1f} mm and {:.2f} deg", 1e3 * of["distance_m"].get<double>(),
                       kDegrees * of["pitch_rad"].get<double>());
  };
  fmt::print(stderr, "ends {} from its plan, torques reach {:.2f} of the motors' limits\n",
             distance(played), played["limit_share"].get<double>());
  for (const auto& [part, of] : played["without"].items())
    fmt::print(stderr, "  without {}: {}\n", part, distance(of));
}

/// "attach.tail.kind=none" as an override.
model::Override override_of(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos)
    throw InputError(fmt::format("'{}' given; allowed: PATH=VALUE", text));
  const auto node = yaml::Node::parse("{value: " + text.substr(equals + 1) + "}", "PATH=VALUE");
  return {text.substr(0, equals), node.at("value")};
}

Json run(const std::vector<std::string>& given) {
  const fs::path export_file = given[2];
  transcription::Problem problem = transcription::read_problem(given[0]);
  for (std::size_t i = 3; i < given.size(); ++i) problem.overrides.push_back(override_of(given[i]));
  const model::Robot read = model::read_robot(problem.robot_folder, problem.overrides);
  const PlanarModel planar = test::played_model(problem, read.planar);
  std::ifstream in(export_file);
  const Json exported = Json::parse(in);
  if (exported.at("format") != "jaculus-export/2" || exported.at("side") != "joint" ||
      !exported.at("joints_of_robot_file").get<bool>())
    throw InputError(export_file.string() + ": allowed: `export --as json` of joints of the file");

  const model::SpatialTree tree = test::played_tree(read, problem.overrides);
  const test::BodiesFile bodies(read);
  const Playing playing{problem, planar, tree, bodies.path(), ends_of(given[1], planar), exported};
  Json played = play(playing, Part::none, false);
  if (is_far(played)) played["without"] = parts(playing);
  return played;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr,
               "usage: play_export PROBLEM.yaml SOLVE_FOLDER EXPORT.json [PATH=VALUE ...]\n");
    return 2;
  }
  try {
    const Json played = run({argv + 1, argv + argc});
    fmt::print("{}\n", played.dump());
    if (!is_far(played)) return 0;
    explain(played);
    return 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
