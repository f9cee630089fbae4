// summary.json: to_json and its inverse.

#include <fmt/format.h>

#include <fstream>
#include <stdexcept>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/json.h"
#include "jaculus/solver/summary.h"

namespace jaculus::solver {
namespace {

using Json = nlohmann::ordered_json;

double number_or(const Json& json, const char* key, double none) {
  return json.contains(key) && json.at(key).is_number() ? json.at(key).get<double>() : none;
}

Json numbers(const std::map<std::string, double>& values) {
  Json json = Json::object();
  for (const auto& [name, value] : values) json[name] = json_number(value);
  return json;
}

Json violation(const RowFigure& v) {
  return {{"row", v.row}, {"value", json_number(v.value)}, {"unit", v.unit}};
}

RowFigure violation_from(const Json& json) {
  return {json.at("row").get<std::string>(), number_or(json, "value", kNaN),
          json.at("unit").get<std::string>()};
}

Json verification(const VerificationFigures& v) {
  return {{"passed", v.passed},
          {"failures", v.failures},
          {"reintegration_error", numbers(v.reintegration_error)},
          {"reintegration_velocity_error", numbers(v.reintegration_velocity_error)},
          {"worst_violation", violation(v.worst_violation)},
          {"off_node_violation", violation(v.off_node_violation)},
          {"momentum_balance", json_number(v.momentum_balance)},
          {"energy_balance", json_number(v.energy_balance)}};
}

std::map<std::string, double> numbers_from(const Json& json) {
  std::map<std::string, double> values;
  for (const auto& [name, value] : json.items())
    values[name] = value.is_number() ? value.get<double>() : kNaN;
  return values;
}

VerificationFigures verification_from(const Json& json) {
  VerificationFigures v;
  v.passed = json.at("passed").get<bool>();
  v.failures = json.at("failures").get<std::vector<std::string>>();
  v.reintegration_error = numbers_from(json.at("reintegration_error"));
  v.reintegration_velocity_error = numbers_from(json.at("reintegration_velocity_error"));
  v.worst_violation = violation_from(json.at("worst_violation"));
  v.off_node_violation = violation_from(json.at("off_node_violation"));
  v.momentum_balance = number_or(json, "momentum_balance", kNaN);
  v.energy_balance = number_or(json, "energy_balance", kNaN);
  return v;
}

/// Names of the figures of a motor in JSON and where they stand; a limit that is absent is
/// infinite.
struct MotorKey {
  const char* key;
  double MotorFigures::*field;
  double none;
};
constexpr MotorKey kMotorKeys[] = {
    {"peak_joint_torque_N_m", &MotorFigures::joint_torque, kNaN},
    {"peak_torque_N_m", &MotorFigures::motor_torque, kNaN},
    {"peak_current_A", &MotorFigures::current, kNaN},
    {"peak_voltage_V", &MotorFigures::voltage, kNaN},
    {"torque_limit_N_m", &MotorFigures::torque_limit, kInfinity},
    {"current_limit_A", &MotorFigures::current_limit, kInfinity},
    {"voltage_limit_V", &MotorFigures::voltage_limit, kInfinity},
    {"speed_limit_rad_s", &MotorFigures::speed_limit, kInfinity},
    {"gear", &MotorFigures::gear, kNaN},
    {"efficiency", &MotorFigures::efficiency, kNaN},
    {"torque_constant_N_m_A", &MotorFigures::torque_constant, kNaN},
    {"resistance_ohm", &MotorFigures::resistance, kNaN},
    {"saturation_linear_A_N_m", &MotorFigures::saturation_linear, kNaN},
    {"saturation_cubic_A_N_m3", &MotorFigures::saturation_cubic, kNaN},
    {"dry_friction_N_m", &MotorFigures::dry_friction, 0.0}};

Json motor(const MotorFigures& m) {
  Json json = {{"motor", m.joint}, {"count", m.count}, {"slides", m.slides}};
  json["joints"] = Json::array();
  for (const model::FileJoint& joint : m.file_joints)
    json["joints"].push_back(
        {{"joint", joint.name}, {"sign", joint.sign}, {"attached", joint.attached}});
  for (const MotorKey& key : kMotorKeys) json[key.key] = json_number(m.*key.field);
  return json;
}

MotorFigures motor_from(const Json& json) {
  MotorFigures m;
  m.joint = json.at("motor").get<std::string>();
  m.count = json.at("count").get<int>();
  m.slides = json.value("slides", false);  // this and the next are of later versions
  for (const Json& joint : json.value("joints", Json::array())) {
    m.file_joints.push_back({joint.at("joint").get<std::string>(), joint.at("sign").get<double>(),
                             joint.value("attached", false)});
  }
  for (const MotorKey& key : kMotorKeys) m.*key.field = number_or(json, key.key, key.none);
  return m;
}

transcription::InputHold hold_from(const std::string& name) {
  const auto hold = transcription::input_holds().find(name);
  if (!hold) throw std::invalid_argument("input_hold is neither held nor linear");
  return *hold;
}

Summary read(const Json& json) {
  Summary s;
  s.name = json.at("name").get<std::string>();
  s.caption = json.at("caption").get<std::string>();
  s.status = status_from_string(json.at("status").get<std::string>());
  s.message = json.at("message").get<std::string>();
  s.objective = number_or(json, "objective", kNaN);
  s.iterations = json.at("iterations").get<int>();
  const Json& size = json.at("size");
  s.size = {size.at("variables").get<int>(), size.at("constraints").get<int>(),
            size.at("jacobian_nonzeros").get<int>(), size.at("hessian_nonzeros").get<int>()};
  s.duration = number_or(json, "duration_s", kNaN);
  for (const Json& phase : json.at("phases")) {
    s.phases.push_back({phase.at("name").get<std::string>(), number_or(phase, "duration_s", kNaN),
                        phase.at("duration_at_bound").get<bool>()});
  }

  s.liftoff_velocity = number_or(json, "liftoff_velocity_m_s", kNaN);
  s.liftoff_velocity_com = number_or(json, "liftoff_velocity_com_m_s", kNaN);
  s.liftoff_rise_com = number_or(json, "liftoff_rise_com_m_s", kNaN);
  s.average_acceleration = number_or(json, "average_acceleration_m_s2", kNaN);
  s.average_acceleration_com = number_or(json, "average_acceleration_com_m_s2", kNaN);
  s.tail_momentum_share = number_or(json, "tail_momentum_share", kNaN);
  for (const Json& item : json.at("motors")) s.motors.push_back(motor_from(item));
  for (const Json& joint : json.value("held_joints", Json::array())) {
    s.held_joints.push_back({joint.at("joint").get<std::string>(), joint.at("value").get<double>(),
                             joint.at("slides").get<bool>()});
  }
  for (const Json& limit : json.at("active_limits")) {
    s.active_limits.push_back({limit.at("name").get<std::string>(),
                               limit.at("phase").get<std::string>(),
                               number_or(limit, "from_s", kNaN), number_or(limit, "to_s", kNaN),
                               limit.at("nodes").get<int>()});
  }

  for (const Json& price : json.at("prices")) {
    s.gains.push_back({price.at("limit").get<std::string>(), number_or(price, "price", kNaN),
                       price.at("unit").get<std::string>()});
  }

  s.verification = verification_from(json.at("verification"));
  s.warnings = json.at("warnings").get<std::vector<std::string>>();
  s.binds = json.value("binds", std::string());
  for (const Json& row : json.at("violated_rows")) s.violated_rows.push_back(violation_from(row));
  for (const Json& row : json.at("conflict").at("give_way"))
    s.conflict.push_back(violation_from(row));
  s.conflict_against = json.at("conflict").at("against").get<std::vector<std::string>>();
  s.input_hold = hold_from(json.at("input_hold").get<std::string>());
  s.reference = numbers_from(json.at("reference"));
  s.seed = json.at("seed").get<int>();
  s.robot_folder = json.value("robot_folder", std::string());
  s.problem = json.at("problem");

  return s;
}

}  // namespace

Json to_json(const Summary& s) {
  Json json = {{"name", s.name},
               {"caption", s.caption},
               {"status", to_string(s.status)},
               {"converged", s.converged()},
               {"message", s.message},
               {"objective", json_number(s.objective)},
               {"iterations", s.iterations},
               {"size",
                {{"variables", s.size.variables},
                 {"constraints", s.size.constraints},
                 {"jacobian_nonzeros", s.size.jacobian_nonzeros},
                 {"hessian_nonzeros", s.size.hessian_nonzeros}}},
               {"duration_s", json_number(s.duration)}};
  json["phases"] = Json::array();
  for (const PhaseFigures& p : s.phases) {
    json["phases"].push_back({{"name", p.name},
                              {"duration_s", json_number(p.duration)},
                              {"duration_at_bound", p.at_bound}});
  }

  json["liftoff_velocity_m_s"] = json_number(s.liftoff_velocity);
  json["liftoff_velocity_com_m_s"] = json_number(s.liftoff_velocity_com);
  json["liftoff_rise_com_m_s"] = json_number(s.liftoff_rise_com);
  json["average_acceleration_m_s2"] = json_number(s.average_acceleration);
  json["average_acceleration_com_m_s2"] = json_number(s.average_acceleration_com);
  json["tail_momentum_share"] = json_number(s.tail_momentum_share);
  json["motors"] = Json::array();
  for (const MotorFigures& m : s.motors) json["motors"].push_back(motor(m));
  json["held_joints"] = Json::array();
  for (const model::HeldJoint& j : s.held_joints)
    json["held_joints"].push_back({{"joint", j.joint}, {"value", j.value}, {"slides", j.slides}});
  json["active_limits"] = Json::array();
  for (const PlanLimit& a : s.active_limits) {
    json["active_limits"].push_back({{"name", a.name},
                                     {"phase", a.phase},
                                     {"from_s", json_number(a.from)},
                                     {"to_s", json_number(a.to)},
                                     {"nodes", a.nodes}});
  }

  json["prices"] = Json::array();
  for (const LimitGain& g : s.gains) {
    json["prices"].push_back(
        {{"limit", g.limit}, {"price", json_number(g.gain)}, {"unit", g.unit}});
  }

  json["verification"] = verification(s.verification);
  json["warnings"] = s.warnings;
  json["binds"] = s.binds;
  json["violated_rows"] = Json::array();
  for (const RowFigure& v : s.violated_rows) json["violated_rows"].push_back(violation(v));
  json["conflict"] = {{"give_way", Json::array()}, {"against", s.conflict_against}};
  for (const RowFigure& v : s.conflict) json["conflict"]["give_way"].push_back(violation(v));
  json["input_hold"] = name_of(s.input_hold);
  json["reference"] = numbers(s.reference);
  json["seed"] = s.seed;
  json["version"] = version();
  if (!s.robot_folder.empty()) json["robot_folder"] = s.robot_folder;
  json["problem"] = s.problem;

  return json;
}

Summary summary_from_json(const Json& json, const std::string& file) {
  try {
    return read(json);
  } catch (const std::exception& error) {
    throw InputError(
        fmt::format("{}: {}; allowed: a summary.json that jaculus wrote", file, error.what()));
  }
}

Summary read_summary(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream)
    throw InputError(
        fmt::format("{}: can't be read; allowed: a readable summary.json", file.string()));

  const Json json = Json::parse(stream, nullptr, false);
  if (json.is_discarded()) {
    throw InputError(
        fmt::format("{}: not JSON; allowed: a summary.json that jaculus wrote", file.string()));
  }
  return summary_from_json(json, file.string());
}

}  // namespace jaculus::solver
