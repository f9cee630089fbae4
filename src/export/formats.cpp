// The formats of an exported plan.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/core/json.h"
#include "jaculus/export/export.h"

namespace jaculus::exporting {
namespace {

using Json = nlohmann::ordered_json;

/// What every format says of itself, one line each.
std::vector<std::string> notes(const Export& plan) {
  std::vector<std::string> lines = {
      fmt::format("jaculus {}, plan {}: {} samples at {:g} Hz, {:.6g} s", version(), plan.name,
                  plan.time.size(), plan.rate, plan.duration),
      fmt::format("{} side{}; torque of one motor [N m], position [rad], velocity [rad/s]",
                  name_of(plan.side),
                  plan.side == Side::motor ? ", before the gear" : ", behind the gear"),
      fmt::format("each sample is held until the next; the plan's inputs were {}",
                  name_of(plan.plan_hold))};
  std::vector<std::string> pairs;
  for (const ExportedMotor& motor : plan.motors) {
    if (motor.count > 1) pairs.push_back(motor.joint);
  }

  if (!pairs.empty())
    lines.push_back(fmt::format("left and right alike: {}", fmt::join(pairs, ", ")));
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
  std::string text = fmt::format("\n/* {} */\nstatic const float {}[{}][{}] = {{\n", caption, name,
                                 plan.time.size(), plan.motors.size());
  for (std::size_t k = 0; k < plan.time.size(); ++k) {
    std::vector<std::string> cells;
    for (const ExportedMotor& motor : plan.motors)
      cells.push_back(fmt::format("{:.8e}f", (motor.*field)[k]));
    text += fmt::format("    {{{}}},\n", fmt::join(cells, ", "));
  }
  return text + "};\n";
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
  std::string text = "time [s]";
  for (const ExportedMotor& m : plan.motors) {
    text += fmt::format(",{0}{1} [rad],{0}{1}_velocity [rad/s],{0}{1}_torque [N m]", m.joint, at);
    if (!m.current.empty()) text += fmt::format(",{0}_current [A],{0}_voltage [V]", m.joint);
  }
  text += "\n";
  for (std::size_t k = 0; k < plan.time.size(); ++k) {
    text += fmt::format("{}", plan.time[k]);
    for (const ExportedMotor& m : plan.motors) {
      text += fmt::format(",{},{},{}", m.position[k], m.velocity[k], m.torque[k]);
      if (!m.current.empty()) text += fmt::format(",{},{}", m.current[k], m.voltage[k]);
    }
    text += "\n";
  }
  return text;
}

std::string to_json(const Export& plan) {
  Json json = {{"format", "jaculus-export/1"},
               {"version", version()},
               {"plan", plan.name},
               {"rate_hz", plan.rate},
               {"duration_s", plan.duration},
               {"side", name_of(plan.side)},
               {"hold", "held"},
               {"plan_hold", name_of(plan.plan_hold)},
               {"limits_checked", !plan.checks.empty()},
               {"limits", checks_json(plan)},
               {"time_s", plan.time}};
  json["motors"] = Json::array();

  for (const ExportedMotor& m : plan.motors) {
    Json motor = {{"name", m.joint},
                  {"count", m.count},
                  {"position_rad", m.position},
                  {"velocity_rad_s", m.velocity},
                  {"torque_N_m", m.torque}};
    if (!m.current.empty()) {
      motor["current_A"] = m.current;
      motor["voltage_V"] = m.voltage;
    }
    json["motors"].push_back(motor);
  }

  return json.dump(1) + "\n";
}

std::string to_joint_trajectory(const Export& plan) {
  std::string text;
  for (const std::string& line : notes(plan)) text += "# " + line + "\n";
  std::vector<std::string> names;
  for (const ExportedMotor& m : plan.motors) names.push_back(m.joint);
  text += "header:\n  stamp: {sec: 0, nanosec: 0}\n  frame_id: ''\n";
  text += fmt::format("joint_names: [{}]\npoints:\n", fmt::join(names, ", "));

  for (std::size_t k = 0; k < plan.time.size(); ++k) {
    std::vector<double> p, v, tau;
    for (const ExportedMotor& m : plan.motors) {
      p.push_back(m.position[k]);
      v.push_back(m.velocity[k]);
      tau.push_back(m.torque[k]);
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
  text +=
      fmt::format("#define {0}_SAMPLES {1}\n#define {0}_MOTORS {2}\n#define {0}_RATE_HZ {3:.9e}f\n",
                  guard, plan.time.size(), plan.motors.size(), plan.rate);

  std::vector<std::string> names;
  for (const ExportedMotor& m : plan.motors) names.push_back('"' + m.joint + '"');
  text += fmt::format("\nstatic const char *const {}_motor[{}] = {{{}}};\n", prefix,
                      plan.motors.size(), fmt::join(names, ", "));
  text += c_array(prefix + "_torque", side + " torque [N m]", plan, &ExportedMotor::torque);
  text += c_array(prefix + "_position", side + " position [rad]", plan, &ExportedMotor::position);
  text += c_array(prefix + "_velocity", side + " velocity [rad/s]", plan, &ExportedMotor::velocity);

  return text + "\n#endif\n";
}

}  // namespace jaculus::exporting
