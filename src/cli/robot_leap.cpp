#include "cli/robot_leap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/yaml.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/transcription/robot_size.h"

namespace jaculus::cli {
namespace {

using model::PlanarModel;

/// Joints without a range in the file get one: 1.5 rad either way of rest.
std::string assumed_ranges(const model::Robot& robot) {
  const PlanarModel& model = robot.planar;
  std::string text;
  for (const model::Coordinate& c : model.coordinates) {
    const bool ranged = std::isfinite(c.range.lower) && std::isfinite(c.range.upper);
    if (model.body_of_joint(c.name) < 0 || ranged) continue;
    const auto found = robot.rest_pose.find(c.name);
    const double rest = found == robot.rest_pose.end() ? 0.0 : found->second;
    text += fmt::format("    {}: [{:.4g}, {:.4g}]   # no range in the file: 1.5 rad about rest\n",
                        yaml::quoted(c.name), rest - 1.5, rest + 1.5);
  }
  return text.empty() ? "" : "bounds:\n  position:\n" + text;
}

/// A torque for motors of which nobody stated one.
std::string assumed_torque(const PlanarModel& model) {
  const bool known = std::all_of(model.motors.begin(), model.motors.end(), [](const auto& motor) {
    return std::isfinite(motor.torque_limit);
  });
  if (known) return "";
  return fmt::format(
      "limits: {{torque: {} body_weight leg_length}}   # fill in: the file states none\n",
      kTorqueAssumed);
}

std::string leap(const model::Robot& robot, const transcription::RobotSize& size) {
  return fmt::format(
             "# A leap from rest, posed by leap_template.yaml in units of the robot: leg_length "
             "{:.3g} m,\n# standing_height {:.3g} m, body_weight {:.4g} N, leg_time {:.3g} s.\n"
             "format: jaculus-problem/1\nextends: leap_template.yaml\nname: leap\nrobot: .\n",
             size.leg_length, size.standing_height, size.body_weight, size.leg_time) +
         assumed_torque(robot.planar) + assumed_ranges(robot);
}

}  // namespace

std::string write_first_leap(const model::Robot& robot, const model::Proposal& proposal,
                             const std::filesystem::path& folder) {
  const PlanarModel& model = robot.planar;
  const bool slides = std::any_of(model.bodies.begin(), model.bodies.end(), [](const auto& body) {
    return body.kind == model::JointKind::prismatic;
  });
  const bool legs = model.feet.size() == 2 && model.foot_index("front_foot") >= 0 &&
                    model.foot_index("rear_foot") >= 0;
  const bool can = proposal.floating && legs && !slides && !model.motors.empty();
  if (!can || robot.rest_pose.empty()) return "";

  const transcription::RobotSize size = transcription::robot_size(robot);
  constexpr double kLeg = 0.01;  // [m]: a drone's rotors are no legs
  if (size.leg_length < kLeg) return "";
  trajectory::write_file(folder / "leap.yaml", leap(robot, size));
  return "leap.yaml";
}

}  // namespace jaculus::cli
