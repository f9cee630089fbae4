// The formats of an exported plan.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>

#include "jaculus/core/installation.h"
#include "jaculus/core/json.h"
#include "jaculus/export/export.h"

namespace jaculus::exporting {
namespace {

using Json = nlohmann::ordered_json;

/// "left [rad]" and the like of one joint.
struct Units {
  const char *position, *velocity, *torque;
};
Units units_of(const ExportedMotor& motor) {
  return motor.slides ? Units{"m", "m/s", "N"} : Units{"rad", "rad/s", "N m"};
}

std::vector<double> times(double sign, std::vector<double> values) {
  for (double& value : values) value *= sign;
  return values;
}

/// "joint position [rad]"; units joint by joint where some slide.
std::string caption(const Export& plan, const std::string& what, const char* Units::*unit) {
  std::vector<std::string> units;
  for (const PlayedJoint& joint : played_joints(plan))
    units.push_back(units_of(*joint.motor).*unit);
  const bool alike =
      std::adjacent_find(units.begin(), units.end(), std::not_equal_to<>()) == units.end();
  if (alike && !units.empty()) units.resize(1);
  return fmt::format("{} [{}]", what, fmt::join(units, ", "));
}

/// Joints that the robot's own file doesn't have.
std::vector<std::string> attached_joints(const Export& plan) {
  std::vector<std::string> names;
  for (const PlayedJoint& joint : played_joints(plan))
    if (joint.attached) names.push_back(joint.name);
  return names;
}

/// Which joints play what, and which are to be held.
std::vector<std::string> joint_notes(const Export& plan) {
  std::vector<std::string> lines;
  for (const ExportedMotor& motor : plan.motors) {
    std::vector<std::string> joints;
    for (const model::FileJoint& joint : motor.file_joints)
      joints.push_back((joint.sign < 0.0 ? "minus " : "") + joint.name);
    if (joints.size() > 1 || joints.front() != motor.joint)
      lines.push_back(fmt::format("{} of the plan is {}", motor.joint, fmt::join(joints, ", ")));
  }
  if (!plan.file_joints_known) {
    lines.emplace_back(
        "joints are the plan's, not the robot file's: no summary.json of this version, no --robot");
  }

  const std::vector<std::string> attached = attached_joints(plan);
  if (!attached.empty()) {
    lines.push_back(fmt::format(
        "{}: attached by robot.yaml, not in the robot's file; `jaculus robot urdf` writes one "
        "that has it",
        fmt::join(attached, ", ")));
  }
  for (const model::HeldJoint& joint : plan.held_joints) {
    lines.push_back(
        fmt::format("{} stands still at {:.6g} {}{}: to be held, its load is not planned",
                    joint.joint, joint.value, joint.slides ? "m" : "rad",
                    plan.side == Side::motor ? " behind its gear, of which nothing is known" : ""));
  }
  return lines;
}

/// What every format says of itself, one line each.
std::vector<std::string> notes(const Export& plan) {
  std::vector<std::string> lines = {
      fmt::format("jaculus {}, plan {}: {} samples at {:g} Hz, {:.6g} s", version(), plan.name,
                  plan.time.size(), plan.rate, plan.duration),
      fmt::format("{} side{}; {}, {}, {}", name_of(plan.side),
                  plan.side == Side::motor ? ", before the gear" : ", behind the gear",
                  caption(plan, "torque of one motor", &Units::torque),
                  caption(plan, "position", &Units::position),
                  caption(plan, "velocity", &Units::velocity)),
      "joints, their signs and zeros are those of the robot's file",
      fmt::format("each sample is held until the next, its torque is the plan's mean over it; the "
                  "plan's inputs were {}",
                  name_of(plan.plan_hold))};
  if (!plan.file_joints_known) lines.erase(lines.begin() + 2);
  for (const std::string& line : joint_notes(plan)) lines.push_back(line);

  if (plan.checks.empty()) lines.emplace_back("limits not known, not checked");
  for (const LimitCheck& check : plan.checks) {
    if (!check.exceeded) continue;
    lines.push_back(fmt::format("LIMIT EXCEEDED: {} {} {:.4g} {} of {:.4g} at {:.4g} s",
                                check.joint, name_of(check.quantity), check.peak, check.unit,
                                check.limit, check.time));
  }

  return lines;
}

std::string identifier(const std::string& name) {
  std::string result;
  for (const char c : name) result += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return !result.empty() && std::isdigit(static_cast<unsigned char>(result[0])) != 0 ? "_" + result
                                                                                     : result;
}

std::string c_array(const std::string& name, const std::string& caption, const Export& plan,
                    std::vector<double> ExportedMotor::*field) {
  const std::vector<PlayedJoint> joints = played_joints(plan);
  std::string text = fmt::format("\n/* {} */\nstatic const float {}[{}][{}] = {{\n", caption, name,
                                 plan.time.size(), joints.size());
  for (std::size_t k = 0; k < plan.time.size(); ++k) {
    std::vector<std::string> cells;
    for (const PlayedJoint& joint : joints)
      cells.push_back(fmt::format("{:.8e}f", joint.sign * (joint.motor->*field)[k]));
    text += fmt::format("    {{{}}},\n", fmt::join(cells, ", "));
  }
  return text + "};\n";
}

std::string c_held_joints(const std::string& prefix, const Export& plan) {
  if (plan.held_joints.empty()) return "";
  std::vector<std::string> names, positions;
  for (const model::HeldJoint& joint : plan.held_joints) {
    names.push_back('"' + joint.joint + '"');
    positions.push_back(fmt::format("{:.8e}f", joint.value));
  }
  const std::size_t count = names.size();
  return fmt::format(
      "\n/* to be held, on the joint's side of the gear [rad, m where it slides] */\nstatic const "
      "char *const {0}_held_joint[{1}] = {{{2}}};\n"
      "static const float {0}_held_position[{1}] = {{{3}}};\n",
      prefix, count, fmt::join(names, ", "), fmt::join(positions, ", "));
}

}  // namespace

const NameTable<Side>& sides() {
  static const NameTable<Side> table({{Side::joint, "joint"}, {Side::motor, "motor"}});
  return table;
}

const char* name_of(Side side) { return sides().name(side); }

const std::vector<Format>& formats() {
  static const std::vector<Format> all = {
      {"c", to_c}, {"csv", to_csv}, {"joint_trajectory", to_joint_trajectory}, {"json", to_json}};
  return all;
}

nlohmann::ordered_json checks_json(const Export& plan) {
  Json json = Json::array();
  for (const LimitCheck& c : plan.checks) {
    json.push_back({{"motor", c.joint},
                    {"quantity", name_of(c.quantity)},
                    {"unit", c.unit},
                    {"peak", c.peak},
                    {"time_s", c.time},
                    {"limit", json_number(c.limit)},
                    {"exceeded", c.exceeded}});
  }
  return json;
}

std::string to_csv(const Export& plan) {
  // A CSV has no place for notes but its column names, so these state side and units.
  const std::string at = plan.side == Side::motor ? "_motor" : "";
  const std::vector<PlayedJoint> joints = played_joints(plan);
  std::string text = "time [s]";
  for (const PlayedJoint& joint : joints) {
    const auto [position, velocity, torque] = units_of(*joint.motor);
    text += fmt::format(",{0}{1} [{2}],{0}{1}_velocity [{3}],{0}{1}_torque [{4}]", joint.name, at,
                        position, velocity, torque);
    if (!joint.motor->current.empty())
      text += fmt::format(",{0}_current [A],{0}_voltage [V]", joint.name);
  }
  for (const model::HeldJoint& joint : plan.held_joints)
    text += fmt::format(",{} [{}]", joint.joint, joint.slides ? "m" : "rad");

  text += "\n";
  for (std::size_t k = 0; k < plan.time.size(); ++k) {
    text += fmt::format("{}", plan.time[k]);
    for (const auto& [name, sign, m, attached] : joints) {
      text += fmt::format(",{},{},{}", sign * m->position[k], sign * m->velocity[k],
                          sign * m->torque[k]);
      if (!m->current.empty())
        text += fmt::format(",{},{}", sign * m->current[k], sign * m->voltage[k]);
    }
    for (const model::HeldJoint& joint : plan.held_joints) text += fmt::format(",{}", joint.value);
    text += "\n";
  }
  return text;
}

std::string to_json(const Export& plan) {
  Json json = {{"format", "jaculus-export/2"},
               {"version", version()},
               {"plan", plan.name},
               {"rate_hz", plan.rate},
               {"duration_s", plan.duration},
               {"side", name_of(plan.side)},
               {"hold", "held"},
               {"plan_hold", name_of(plan.plan_hold)},
               {"joints_of_robot_file", plan.file_joints_known},
               {"limits_checked", !plan.checks.empty()},
               {"limits", checks_json(plan)},
               {"time_s", plan.time}};
  json["joints"] = Json::array();

  for (const auto& [name, sign, m, attached] : played_joints(plan)) {
    const auto [position, velocity, torque] = units_of(*m);
    Json joint = {{"name", name},
                  {"motor", m->joint},
                  {"sign", sign},
                  {"attached", attached},
                  {"units", {position, velocity, torque}},
                  {"position", times(sign, m->position)},
                  {"velocity", times(sign, m->velocity)},
                  {"torque", times(sign, m->torque)}};
    if (!m->current.empty()) {
      joint["current_A"] = times(sign, m->current);
      joint["voltage_V"] = times(sign, m->voltage);
    }
    json["joints"].push_back(joint);
  }

  json["held_joints"] = Json::array();
  for (const model::HeldJoint& joint : plan.held_joints)
    json["held_joints"].push_back({{"name", joint.joint},
                                   {"side", name_of(Side::joint)},
                                   {"unit", joint.slides ? "m" : "rad"},
                                   {"position", joint.value}});
  return json.dump(1) + "\n";
}

std::string to_joint_trajectory(const Export& plan) {
  std::string text;
  for (const std::string& line : notes(plan)) text += "# " + line + "\n";
  const std::vector<PlayedJoint> joints = played_joints(plan);
  std::vector<std::string> names;
  for (const PlayedJoint& joint : joints) names.push_back(joint.name);
  for (const model::HeldJoint& joint : plan.held_joints) names.push_back(joint.joint);
  text += "header:\n  stamp: {sec: 0, nanosec: 0}\n  frame_id: ''\n";
  text += fmt::format("joint_names: [{}]\npoints:\n", fmt::join(names, ", "));

  for (std::size_t k = 0; k < plan.time.size(); ++k) {
    std::vector<double> p, v, tau;
    for (const auto& [name, sign, m, attached] : joints) {
      p.push_back(sign * m->position[k]);
      v.push_back(sign * m->velocity[k]);
      tau.push_back(sign * m->torque[k]);
    }
    for (const model::HeldJoint& joint : plan.held_joints) {
      p.push_back(joint.value);
      v.push_back(0.0);
      tau.push_back(0.0);  // a message has an effort for every joint or for none
    }
    const auto nanoseconds = static_cast<long long>(std::llround(plan.time[k] * 1e9));
    text += fmt::format(
        "- positions: [{}]\n  velocities: [{}]\n  accelerations: []\n  effort: [{}]\n"
        "  time_from_start: {{sec: {}, nanosec: {}}}\n",
        fmt::join(p, ", "), fmt::join(v, ", "), fmt::join(tau, ", "), nanoseconds / 1000000000,
        nanoseconds % 1000000000);
  }

  return text;
}

std::string to_c(const Export& plan) {
  const std::string prefix = identifier(plan.name), side = name_of(plan.side);
  std::string guard = prefix;
  std::transform(guard.begin(), guard.end(), guard.begin(),
                 [](unsigned char c) { return std::toupper(c); });
  std::string text = "/*\n";
  for (const std::string& line : notes(plan)) text += " * " + line + "\n";
  text += fmt::format(" */\n#ifndef {0}_PLAN_H\n#define {0}_PLAN_H\n\n", guard);
  const std::vector<PlayedJoint> joints = played_joints(plan);
  text +=
      fmt::format("#define {0}_SAMPLES {1}\n#define {0}_JOINTS {2}\n#define {0}_RATE_HZ {3:.9e}f\n",
                  guard, plan.time.size(), joints.size(), plan.rate);

  std::vector<std::string> names;
  for (const PlayedJoint& joint : joints) names.push_back('"' + joint.name + '"');
  text += fmt::format("\nstatic const char *const {}_joint[{}] = {{{}}};\n", prefix, joints.size(),
                      fmt::join(names, ", "));
  text += c_held_joints(prefix, plan);
  text += c_array(prefix + "_torque", caption(plan, side + " torque", &Units::torque), plan,
                  &ExportedMotor::torque);
  text += c_array(prefix + "_position", caption(plan, side + " position", &Units::position), plan,
                  &ExportedMotor::position);
  text += c_array(prefix + "_velocity", caption(plan, side + " velocity", &Units::velocity), plan,
                  &ExportedMotor::velocity);

  return text + "\n#endif\n";
}

}  // namespace jaculus::exporting
