#include "cli/robot_trial.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "jaculus/core/yaml.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::cli {
namespace {

using model::PlanarModel;

using yaml::quoted;

double at(const std::map<std::string, double>& rest, const std::string& joint) {
  const auto found = rest.find(joint);
  return found == rest.end() ? 0.0 : found->second;
}

/// A pose as a plan: two samples of joints with motors at rest, no torque.
trajectory::Table pose_plan(const PlanarModel& model, const std::map<std::string, double>& rest) {
  const int n = count_of(model.motors);
  trajectory::Table table;
  table.values = Matrix::Zero(2, 1 + 3 * n);
  table.columns.push_back({"time", "s"});
  table.values(1, 0) = 0.5;
  const auto unit = [&](int m, const char* turning, const char* sliding) {
    return model.bodies[model.motors[m].body].kind == model::JointKind::revolute ? turning
                                                                                 : sliding;
  };

  for (int m = 0; m < n; ++m) {
    table.columns.push_back({model.motors[m].joint, unit(m, "rad", "m")});
    table.values.col(1 + m).setConstant(at(rest, model.motors[m].joint));
  }
  for (int m = 0; m < n; ++m)
    table.columns.push_back({model.motors[m].joint + "_velocity", unit(m, "rad/s", "m/s")});
  for (int m = 0; m < n; ++m)
    table.columns.push_back({model.motors[m].joint + "_torque", unit(m, "N m", "N")});
  return table;
}

/// Coordinates of joints without a motor, ", name: value" each; with one where `driven`.
std::string open_joints(const PlanarModel& model, const std::map<std::string, double>& rest,
                        bool driven = false) {
  std::string text;
  for (const model::Coordinate& c : model.coordinates) {
    if (model.body_of_joint(c.name) < 0 || (!driven && model.motor_index(c.name) >= 0)) continue;
    text += fmt::format(", {}: {:.6g}", quoted(c.name), at(rest, c.name));
  }
  return text;
}

/// How far what a joint bears may turn it [rad].
constexpr double kSag = 0.1;

/// Joint stiffness at which the robot's weight, borne at the end of its longest leg, turns a joint
/// by no more [N m/rad].
double leg_stiffness(const PlanarModel& model) {
  double leg = 0.1;  // [m], of a robot without any
  for (const model::PlanarPoint& foot : model.feet) {
    double length = foot.position.norm();
    for (int b = foot.body; b > 0 && model.bodies[b].parent > 0; b = model.bodies[b].parent)
      length += model.bodies[b].origin.norm();
    leg = std::max(leg, length);
  }
  return model.total_mass() * model.gravity * leg / 2.0 / kSag;
}

/// The base's child by which a body hangs on it.
int limb_of(const PlanarModel& model, int body) {
  while (model.bodies[body].parent > 0) body = model.bodies[body].parent;
  return body;
}

/// Limbs that the robot stands on: with a foot, or a link that a loop joins to one.
std::set<int> legs_of(const PlanarModel& model) {
  std::set<int> legs;
  for (const model::PlanarPoint& foot : model.feet) legs.insert(limb_of(model, foot.body));
  for (const int body : model.dependent) legs.insert(limb_of(model, body));
  return legs;
}

/// The same of a joint that bears nothing but what hangs on it: of an arm, a tail, a finger.
double own_stiffness(const PlanarModel& model, const model::PlanarMotor& motor) {
  double moment = 0.0;
  std::vector<double> reach(model.bodies.size(), kNaN);
  reach[motor.body] = 0.0;
  for (int b = motor.body; b < count_of(model.bodies); ++b) {
    const model::PlanarBody& body = model.bodies[b];
    if (b > motor.body) reach[b] = reach[body.parent] + body.origin.norm();
    if (!std::isnan(reach[b])) moment += body.mass * (reach[b] + body.com.norm());
  }
  return moment * model.gravity / motor.count / kSag;
}

/// By motor, `share` of each joint's stiffness.
std::string gains(const PlanarModel& model, double share) {
  std::string text = fmt::format("{{\"*\": {:.4g}", share * leg_stiffness(model));
  const std::set<int> legs = legs_of(model);
  for (const model::PlanarMotor& motor : model.motors)
    if (!legs.empty() && legs.count(limb_of(model, motor.body)) == 0)
      text += fmt::format(", {}: {:.4g}", quoted(motor.joint), share * own_stiffness(model, motor));
  return text + "}";
}

/// A pose held by gains that the robot stands on, damped as a pole of 50 ms.
std::string held_pose(const std::string& name, const model::Robot& robot,
                      const std::map<std::string, double>& rest) {
  constexpr double kPole = 0.05;  // [s]
  const PlanarModel& model = robot.planar;
  const bool stands = !model.feet.empty();
  return fmt::format(
      "# {}, joints held by PD. Gains follow from its weight; they are the joints', whatever the "
      "gear.\n"
      "format: jaculus-experiment/1\nname: {}\nexperiment: {}\nrobot: .\nplan: {}.csv\n"
      "initial: {{x: 0, z: {}, pitch: 0{}}}\n"
      "controller: {{kind: feedforward_pd, quantity: torque, rate_hz: 1000, kp: {}, kd: {}, "
      "gains_at: joint, after_end: hold}}\nduration: {} ms\n",
      stands ? "Stands on its feet for half a second" : "Falls freely, for it has no feet", name,
      stands ? "leap" : "self_righting", name, stands ? 0 : 1, open_joints(model, rest),
      gains(model, 1.0), gains(model, kPole), stands ? 500 : 200);
}

/// A script of a tenth of the motors' torque one way, then the other.
std::string swing(const model::Robot& robot, const std::map<std::string, double>& rest) {
  const PlanarModel& model = robot.planar;
  std::vector<std::string> scripts;
  for (const model::PlanarMotor& motor : model.motors) {
    // of a motor whose largest torque nobody stated, that of a tenth of the robot's weight at 0.1 m
    const double torque = std::isfinite(motor.torque_limit) ? 0.1 * motor.torque_limit
                                                            : 0.01 * model.total_mass() * kGravity;
    scripts.push_back(fmt::format("{}: [[0, {:.4g}], [0.2, {:.4g}], [0.4, 0]]", quoted(motor.joint),
                                  torque, -torque));
  }
  return fmt::format(
      "# A tenth of each motor's torque, one way and back.\n"
      "format: jaculus-experiment/1\nname: swing\nexperiment: pendulum\nrobot: .\n"
      "input: {{torque: {{{}}}}}\ninitial: {{{}}}\ncontroller: {{kind: torque, rate_hz: 500}}\n"
      "duration: 500 ms\n",
      fmt::join(scripts, ", "), open_joints(model, rest, true).substr(2));
}

}  // namespace

std::string write_first_trial(const model::Robot& robot, const std::map<std::string, double>& rest,
                              const std::filesystem::path& folder) {
  const PlanarModel& model = robot.planar;
  const bool free = model.base_free[0] && model.base_free[1] && model.base_free[2];
  const bool slides = std::any_of(model.motors.begin(), model.motors.end(),
                                  [&](const auto& m) { return model.slides(m); });
  if (model.motors.empty() || (free && slides)) return "";  // a plan holds torques alone

  const std::string name = !free ? "swing" : model.feet.empty() ? "fall" : "stand";
  if (free) trajectory::write_csv(pose_plan(model, rest), folder / (name + ".csv"));
  trajectory::write_file(folder / (name + ".yaml"),
                         free ? held_pose(name, robot, rest) : swing(robot, rest));
  return name + ".yaml";
}

}  // namespace jaculus::cli
