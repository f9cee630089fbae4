#include "cli/robot_leap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/trajectory/csv.h"

namespace jaculus::cli {
namespace {

using model::PlanarModel;
using Pose = std::map<std::string, double>;

double value_in(const Pose& pose, const std::string& joint) {
  const auto found = pose.find(joint);
  return found == pose.end() ? 0.0 : found->second;
}

/// What the problem is scaled by.
struct Size {
  double leg = 0.0;     ///< from hip to foot, stretched [m]
  double height = 0.0;  ///< of the base over the feet, at rest [m]
  double rise = 0.0;    ///< from there to the stretched pose [m]
  double weight = 0.0;  ///< [N]
  double time = 0.0;    ///< sqrt(L / g) [s]
};

/// Height of the base over a foot with joints as in `pose`; of a body's frame, see planar.h [m].
double height_over(const PlanarModel& model, const model::PlanarPoint& foot, const Pose& pose) {
  std::vector<int> chain;
  for (int b = foot.body; b > 0; b = model.bodies[b].parent) chain.insert(chain.begin(), b);
  double z = 0.0;
  double phi = 0.0;
  const auto down = [&](const Vec2& v) { z += -std::sin(phi) * v.x() + std::cos(phi) * v.y(); };
  for (const int b : chain) {
    const model::PlanarBody& body = model.bodies[b];
    down(body.origin);
    phi += body.angle_offset + body.sign * value_in(pose, body.joint);
  }
  down(foot.position);
  return -z;
}

Size size_of(const PlanarModel& model, const model::Proposal& proposal) {
  Size size;
  for (const model::PlanarPoint& foot : model.feet) {
    double length = foot.position.norm();
    for (int b = foot.body; b > 0 && model.bodies[b].parent > 0; b = model.bodies[b].parent)
      length += model.bodies[b].origin.norm();
    size.leg = std::max(size.leg, length);
    const double height = height_over(model, foot, proposal.rest);
    size.height = std::max(size.height, height);
    size.rise = std::max(size.rise, height_over(model, foot, proposal.stretched) - height);
  }
  size.weight = model.total_mass() * model.gravity;
  size.time = std::sqrt(size.leg / model.gravity);
  return size;
}

std::string in_quotes(const std::string& name) { return "\"" + name + "\""; }

/// Coordinates that are joints, as `function` shows them, one a line.
template <class Function>
std::string joint_lines(const PlanarModel& model, const std::string& indent, Function&& function) {
  std::string text;
  for (const model::Coordinate& c : model.coordinates)
    if (model.body_of_joint(c.name) >= 0)
      text += fmt::format("{}{}: {}\n", indent, in_quotes(c.name), function(c));
  return text;
}

/// A joint's range, less a twentieth at each end; two turns either way of rest where it has none.
std::string range_text(const model::Coordinate& c, const model::Proposal& proposal) {
  if (!std::isfinite(c.range.lower) || !std::isfinite(c.range.upper)) {
    const double rest = value_in(proposal.rest, c.name);
    return fmt::format("[{:.4g}, {:.4g}]   # no range in the file: 1.5 rad about the pose at rest",
                       rest - 1.5, rest + 1.5);
  }
  const double margin = 0.05 * (c.range.upper - c.range.lower);
  return fmt::format("[{:.4g}, {:.4g}]", c.range.lower + margin, c.range.upper - margin);
}

std::string bounds(const PlanarModel& model, const model::Proposal& proposal, const Size& size) {
  std::string text = fmt::format(
      "bounds:\n  position:\n    x: [{:.3g} m, {:.3g} m]\n    z: [{:.3g} m, {:.3g} m]\n"
      "    pitch: [-45 deg, 45 deg]\n",
      -2.0 * size.leg, 4.0 * size.leg, 0.5 * size.height, 2.0 * size.height);
  text += joint_lines(model, "    ", [&](const auto& c) { return range_text(c, proposal); });
  text +=
      "  velocity:\n    x: [-10 m/s, 10 m/s]\n    z: [-10 m/s, 10 m/s]\n"
      "    pitch: [-30 rad/s, 30 rad/s]\n";
  return text + joint_lines(model, "    ", [&](const auto& c) {
           const auto stated = proposal.speed.find(c.name);
           const bool known = stated != proposal.speed.end();
           const double most = known ? stated->second : 30.0;
           return fmt::format("[{:.4g}, {:.4g}]{}", -most, most,
                              known ? "" : "   # fill in: the file states none");
         });
}

std::string limits(const PlanarModel& model, const Size& size) {
  const bool known = std::all_of(model.motors.begin(), model.motors.end(), [](const auto& motor) {
    return std::isfinite(motor.torque_limit);
  });
  const std::string torque =
      known ? "" : fmt::format("torque: {:.3g}, ", size.weight * size.leg / 4.0);
  return fmt::format("limits: {{{}friction: {:.3g}}}{}\n", torque, model.friction / 2.0,
                     known ? "" : "   # fill in: the file states no torque; this is W L / 4");
}

std::string pose_text(const PlanarModel& model, const Pose& pose) {
  std::string text;
  for (const model::Coordinate& c : model.coordinates)
    if (model.body_of_joint(c.name) >= 0)
      text += fmt::format(", {}: {:.5g}", in_quotes(c.name), value_in(pose, c.name));
  return text;
}

std::string leap(const model::Robot& robot, const model::Proposal& proposal) {
  const PlanarModel& model = robot.planar;
  const Size s = size_of(model, proposal);
  return fmt::format(
             "# A leap from rest, as `jaculus robot import` scales it: L = {:.3g} m, W = {:.4g} "
             "N,\n"
             "# T = sqrt(L / g) = {:.3g} s. `jaculus check --explain` has the keys.\n"
             "format: jaculus-problem/1\nname: leap\nrobot: .\n",
             s.leg, s.weight, s.time) +
         limits(model, s) + bounds(model, proposal, s) +
         fmt::format(
             "phases:\n"
             "  - {{name: all_feet, contacts: [front_foot, rear_foot], intervals: 15, duration: "
             "[{:.3g}, {:.3g}]}}   # T / 4 to 3 T\n"
             "  - {{name: rear_feet, contacts: [rear_foot], intervals: 10, duration: [{:.3g}, "
             "{:.3g}]}}   # T / 10 to 2 T\n",
             0.25 * s.time, 3.0 * s.time, 0.1 * s.time, 2.0 * s.time) +
         fmt::format(
             "initial:\n  at_rest: true\n  position: {{x: 0{}}}   # z and pitch follow from the "
             "feet\n",
             pose_text(model, proposal.rest)) +
         fmt::format(
             "final:\n  velocity: {{x: [{:.3g}, 10]}}   # at least sqrt(g L) / 2\n"
             "constraints:\n  - {{type: friction}}\n"
             "  - {{type: normal_force, min: {:.3g}, phases: [all_feet], skip_last: 3}}   # W / "
             "12\n"
             "  - {{type: force_at_end, phase: all_feet, foot: front_foot, normal: 0}}\n"
             "  - {{type: swing_clearance, feet: [front_foot], phases: [rear_feet], min: 0}}\n"
             "  - {{type: touchdown_pitch, height: {:.3g}, pitch: 0}}\n",
             0.5 * std::sqrt(model.gravity * s.leg), s.weight / 12.0, s.height) +
         fmt::format(
             "objective:\n  maximise:\n    - {{type: mean_acceleration}}\n  minimise:\n"
             "    - {{type: torque_squared, weight: {:.3g}}}\n"
             "transcription: {{scheme: hermite_simpson, inputs: held}}\n"
             "guess:\n  kind: line\n  durations: [{:.3g}, {:.3g}]\n  poses:\n"
             "    - {{x: 0{}}}\n    - {{x: {:.3g}, z: {:.3g}, pitch: -0.1{}}}\n",
             // as in leap_quadruped25.yaml, whose W L / 2 is 67 N m
             0.45 / std::pow(s.weight * s.leg / 2.0, 2.0), s.time, 0.3 * s.time,
             pose_text(model, proposal.rest), 0.3 * s.leg, s.height + s.rise,
             pose_text(model, proposal.stretched));
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
  if (!can || size_of(model, proposal).leg < 0.01) return "";  // [m]: a drone's rotors are no legs
  trajectory::write_file(folder / "leap.yaml", leap(robot, proposal));
  return "leap.yaml";
}

}  // namespace jaculus::cli
