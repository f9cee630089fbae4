// summary.json: to_json and its inverse.

#include <fmt/format.h>

#include "jaculus/core/error.h"
#include "jaculus/core/json.h"
#include "jaculus/report/summary.h"
#include "jaculus/report/version.h"

namespace jaculus {
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

Json violation(const RowFigure& v) { return {{"row", v.row}, {"value", json_number(v.value)}, {"unit", v.unit}}; }

RowFigure violation_from(const Json& json) {
  return {json.at("row").get<std::string>(), number_or(json, "value", kNaN), json.at("unit").get<std::string>()};
}

Json verification(const Verification& v) {
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
  for (const auto& [name, value] : json.items()) values[name] = value.is_number() ? value.get<double>() : kNaN;
  return values;
}

Verification verification_from(const Json& json) {
  Verification v;
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

/// Names of the figures of a motor in JSON and where they stand; a limit that is absent is infinite.
struct MotorKey {
  const char* key;
  double MotorFigures::*field;
  double none;
};
constexpr MotorKey kMotorKeys[] = {{"peak_joint_torque_N_m", &MotorFigures::joint_torque, kNaN},
                                   {"peak_torque_N_m", &MotorFigures::motor_torque, kNaN},
                                   {"peak_current_A", &MotorFigures::current, kNaN},
                                   {"peak_voltage_V", &MotorFigures::voltage, kNaN},
                                   {"torque_limit_N_m", &MotorFigures::torque_limit, kInfinity},
                                   {"current_limit_A", &MotorFigures::current_limit, kInfinity},
                                   {"voltage_limit_V", &MotorFigures::voltage_limit, kInfinity},
                                   {"gear", &MotorFigures::gear, kNaN},
                                   {"efficiency", &MotorFigures::efficiency, kNaN},
                                   {"torque_constant_N_m_A", &MotorFigures::torque_constant, kNaN},
                                   {"resistance_ohm", &MotorFigures::resistance, kNaN},
                                   {"saturation_linear_A_N_m", &MotorFigures::saturation_linear, kNaN},
                                   {"saturation_cubic_A_N_m3", &MotorFigures::saturation_cubic, kNaN}};

Json motor(const MotorFigures& m) {
  Json json = {{"motor", m.motor}, {"count", m.count}};
  for (const MotorKey& key : kMotorKeys) json[key.key] = json_number(m.*key.field);
  return json;
}

MotorFigures motor_from(const Json& json) {
  MotorFigures m;
  m.motor = json.at("motor").get<std::string>();
  m.count = json.at("count").get<int>();
  for (const MotorKey& key : kMotorKeys) m.*key.field = number_or(json, key.key, key.none);
  return m;
}

Summary read(const Json& json) {
  Summary s;
  s.name = json.at("name").get<std::string>();
  s.caption = json.at("caption").get<std::string>();
  s.status = json.at("status").get<std::string>();
  s.converged = json.at("converged").get<bool>();
  s.message = json.at("message").get<std::string>();
  s.objective = number_or(json, "objective", kNaN);
  s.iterations = json.at("iterations").get<int>();
  const Json& size = json.at("size");
  s.size = {size.at("variables").get<int>(), size.at("constraints").get<int>(), size.at("jacobian_nonzeros").get<int>(),
            size.at("hessian_nonzeros").get<int>()};
  s.duration = number_or(json, "duration_s", kNaN);
  for (const Json& phase : json.at("phases")) {
    s.phases.push_back({phase.at("name").get<std::string>(), number_or(phase, "duration_s", kNaN),
                        phase.at("duration_at_bound").get<bool>()});
  }
  s.liftoff_velocity = number_or(json, "liftoff_velocity_m_s", kNaN);
  s.liftoff_velocity_com = number_or(json, "liftoff_velocity_com_m_s", kNaN);
  s.average_acceleration = number_or(json, "average_acceleration_m_s2", kNaN);
  s.average_acceleration_com = number_or(json, "average_acceleration_com_m_s2", kNaN);
  s.tail_momentum_share = number_or(json, "tail_momentum_share", kNaN);
  for (const Json& item : json.at("motors")) s.motors.push_back(motor_from(item));
  for (const Json& limit : json.at("active_limits")) {
    s.active_limits.push_back({limit.at("name").get<std::string>(), limit.at("phase").get<std::string>(),
                               number_or(limit, "from_s", kNaN), number_or(limit, "to_s", kNaN),
                               limit.at("nodes").get<int>()});
  }
  for (const Json& price : json.at("prices")) {
    s.prices.push_back(
        {price.at("limit").get<std::string>(), number_or(price, "price", kNaN), price.at("unit").get<std::string>()});
  }
  s.verification = verification_from(json.at("verification"));
  s.warnings = json.at("warnings").get<std::vector<std::string>>();
  for (const Json& row : json.at("violated_rows")) s.violated_rows.push_back(violation_from(row));
  for (const Json& row : json.at("conflict").at("give_way")) s.conflict.push_back(violation_from(row));
  s.conflict_against = json.at("conflict").at("against").get<std::vector<std::string>>();
  s.input_hold = json.at("input_hold").get<std::string>();
  s.reference = numbers_from(json.at("reference"));
  s.seed = json.at("seed").get<int>();
  s.problem = json.at("problem");
  return s;
}

}  // namespace

std::vector<MotorFigures> motor_figures(const PlanarModel& model) {
  std::vector<MotorFigures> figures;
  for (const PlanarMotor& m : model.motors) {
    MotorFigures f;
    f.motor = m.joint;
    f.count = m.count;
    f.slides = model.bodies[static_cast<std::size_t>(m.body)].kind == JointKind::prismatic;
    f.torque_limit = m.torque_limit;
    f.current_limit = m.current_limit;
    f.voltage_limit = m.voltage;
    f.gear = m.gear;
    f.efficiency = m.efficiency;
    f.torque_constant = m.torque_constant;
    f.resistance = m.resistance;
    f.saturation_linear = m.saturation_linear;
    f.saturation_cubic = m.saturation_cubic;
    figures.push_back(f);
  }
  return figures;
}

Json to_json(const Summary& s) {
  Json json = {{"name", s.name},
               {"caption", s.caption},
               {"status", s.status},
               {"converged", s.converged},
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
    json["phases"].push_back(
        {{"name", p.name}, {"duration_s", json_number(p.duration)}, {"duration_at_bound", p.at_bound}});
  }
  json["liftoff_velocity_m_s"] = json_number(s.liftoff_velocity);
  json["liftoff_velocity_com_m_s"] = json_number(s.liftoff_velocity_com);
  json["average_acceleration_m_s2"] = json_number(s.average_acceleration);
  json["average_acceleration_com_m_s2"] = json_number(s.average_acceleration_com);
  json["tail_momentum_share"] = json_number(s.tail_momentum_share);
  json["motors"] = Json::array();
  for (const MotorFigures& m : s.motors) json["motors"].push_back(motor(m));
  json["active_limits"] = Json::array();
  for (const ActiveLimit& a : s.active_limits) {
    json["active_limits"].push_back({{"name", a.name},
                                     {"phase", a.phase},
                                     {"from_s", json_number(a.from)},
                                     {"to_s", json_number(a.to)},
                                     {"nodes", a.nodes}});
  }
  json["prices"] = Json::array();
  for (const PriceFigure& p : s.prices) {
    json["prices"].push_back({{"limit", p.limit}, {"price", json_number(p.price)}, {"unit", p.unit}});
  }
  json["verification"] = verification(s.verification);
  json["warnings"] = s.warnings;
  json["violated_rows"] = Json::array();
  for (const RowFigure& v : s.violated_rows) json["violated_rows"].push_back(violation(v));
  json["conflict"] = {{"give_way", Json::array()}, {"against", s.conflict_against}};
  for (const RowFigure& v : s.conflict) json["conflict"]["give_way"].push_back(violation(v));
  json["input_hold"] = s.input_hold;
  json["reference"] = numbers(s.reference);
  json["seed"] = s.seed;
  json["version"] = version();
  json["problem"] = s.problem;
  return json;
}

Summary summary_from_json(const Json& json, const std::string& file) {
  try {
    return read(json);
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("{}: {}; allowed: a summary.json that jaculus wrote", file, error.what()));
  }
}

}  // namespace jaculus
