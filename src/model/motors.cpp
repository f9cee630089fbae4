// Motors of robot.yaml.
//
// A torque-speed curve, as data sheets have it, is peak torque t up to a knee w_k, then a straight
// line to no torque at w_0, all before the gear and at the bus voltage V. That line is where
// V = R i + k_t w with i = torque/k_t (components/motor.h), which holds at both of its ends:
//   V = k_t w_0                    =>  k_t = V/w_0
//   V = R t/k_t + k_t w_k          =>  R   = k_t (V - k_t w_k)/t = k_t V (1 - w_k/w_0)/t
// so that the curve is an electric motor with saturation_linear 1/k_t and without a cubic, and
// moves with the voltage as that does. Where it is turned backwards, of which a data sheet says
// nothing, it has its peak torque.
// Limits of validity: no field weakening; losses without load count as none; currents are those of
// an ideal brushed motor, not phase currents.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/fields.h"
#include "model/sections.h"

namespace jaculus::model {
namespace {

const std::vector<std::string>& motor_kinds() {
  static const std::vector<std::string> kinds = {"electric", "envelope", "ideal"};
  return kinds;
}

/// Keys that a torque-speed curve stands in place of.
bool follows_from_curve(std::string_view key) {
  return key == "torque_constant" || key == "resistance" || key == "saturation_linear" ||
         key == "saturation_cubic" || key == "current_limit";
}

/// k_t, R and saturation of the curve; voltage and torque_limit are read already.
void set_curve(const yaml::Node& node, PlanarMotor& motor) {
  constexpr Bounds kMore{1e-12, kInfinity};
  const double no_load = node.at("no_load_speed").number(dimension::angular_velocity, kMore);
  const double knee = node.at("knee_speed").number(dimension::angular_velocity, {0.0, kInfinity});
  if (!(knee < no_load)) {
    throw node.at("knee_speed")
        .error(fmt::format("{:.6g} rad/s given with no_load_speed {:.6g} rad/s; allowed: less (a "
                           "motor without a knee is kind: ideal with speed_limit)",
                           knee, no_load));
  }

  if (!std::isfinite(motor.torque_limit)) {
    throw node.at("torque_limit")
        .error("no limit given; allowed: the peak torque that the curve begins with");
  }

  motor.torque_constant = motor.voltage / no_load;
  motor.saturation_linear = 1.0 / motor.torque_constant;
  motor.saturation_cubic = 0.0;
  motor.resistance =
      motor.torque_constant * motor.voltage * (1.0 - knee / no_load) / motor.torque_limit;
}

void read_fields(const yaml::Node& node, const std::string& kind, bool slides, PlanarMotor& motor) {
  const bool curve = kind == "envelope";
  std::vector<Field> fields = motor_fields(motor, slides);
  if (curve) std::erase_if(fields, [](const Field& f) { return follows_from_curve(f.key()); });

  std::vector<std::string> keys = {"kind"};
  for (const Field& field : fields) keys.push_back(field.key());
  if (kind == "ideal" && !slides) keys.emplace_back("rotor_inertia");
  if (curve) keys.insert(keys.end(), {"knee_speed", "no_load_speed"});
  node.only(keys);

  if (const auto rotor = node.find("rotor_inertia"); rotor && kind == "ideal")
    motor.rotor_inertia = rotor->number(dimension::inertia, {0.0, kInfinity});
  for (const Field& field : fields) {
    const bool required = field.required || (curve && field.key() == "torque_limit");
    if (required || node.has(field.key())) field.read(node.at(field.key()));
  }
  if (curve) set_curve(node, motor);
}

}  // namespace

PlanarMotor read_motor(const std::string& joint, const yaml::Node& node, const PlanarModel& model) {
  PlanarMotor motor;
  motor.joint = joint;
  motor.body = joint_body(node, joint, model);
  const PlanarBody& body = model.bodies[motor.body];
  motor.count = body.count;
  const bool slides = body.kind == JointKind::prismatic;
  if (std::find(model.dependent.begin(), model.dependent.end(), motor.body) !=
      model.dependent.end()) {
    throw node.error(fmt::format(
        "joint '{}' follows from a loop; allowed: motors at independent joints", joint));
  }

  const std::string kind = node.at("kind").choice(motor_kinds());
  if (kind != "ideal" && slides)
    throw node.error(fmt::format("joint '{}' slides; allowed: kind: ideal, a force", joint));
  // tells motor_fields which keys there are; read below where electric
  motor.resistance = kind == "ideal" ? 0.0 : 1.0;
  motor.voltage = kInfinity;
  read_fields(node, kind, slides, motor);
  return motor;
}

void read_motors(const yaml::Node& robot, const Absent& absent, PlanarModel& model) {
  const std::optional<yaml::Node> section = robot.find("motors");
  if (!section) return;
  for (const auto& [name, node] : section->entries())
    if (absent.count(name) == 0) model.motors.push_back(read_motor(name, node, model));
}

std::string motor_text(PlanarMotor motor, const PlanarModel& model) {
  std::string text = fmt::format("{{kind: {}", motor.ideal() ? "ideal" : "electric");
  const std::size_t body = motor.body;
  for (const Field& field : motor_fields(motor, model.bodies[body].kind == JointKind::prismatic)) {
    const double value = **std::get_if<double*>(&field.target);
    if (std::isfinite(value)) text += fmt::format(", {}: {}", field.key(), value);
  }
  return text + "}";
}

void replace_motors(const std::vector<OverrideInput>& overrides, PlanarModel& model) {
  for (const bool wild : {true, false}) {
    for (const OverrideInput& o : overrides) {
      if ((o.path.find('*') != std::string::npos) != wild) continue;
      for (PlanarMotor& motor : model.motors)
        if (matches(o.path, "motors." + motor.joint))
          motor = read_motor(motor.joint, o.value, model);
    }
  }
}

void check_replaced(const std::vector<OverrideInput>& overrides, const Absent& absent,
                    const PlanarModel& model) {
  std::vector<std::string> known;
  for (const PlanarMotor& motor : model.motors) known.push_back("motors." + motor.joint);
  std::vector<std::string> all = known;
  for (const std::string& name : absent) all.push_back("motors." + name);

  for (const OverrideInput& o : overrides) {
    const bool there = std::any_of(all.begin(), all.end(),
                                   [&o](const std::string& path) { return matches(o.path, path); });
    if (!there) throw unknown_name(o.value, "motor", o.path, known);
  }
}

}  // namespace jaculus::model
