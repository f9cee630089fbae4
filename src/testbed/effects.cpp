#include "jaculus/testbed/effects.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"

namespace jaculus::testbed {
namespace {

using Values = std::vector<double>;
const std::vector<std::string> kTail = {"leap", "self_righting", "tail_bench"};
const std::vector<std::string> kLeap = {"leap"};
const std::vector<std::string> kMoving = {"leap", "self_righting"};
const std::vector<std::string> kLegMotors = {"front_a", "front_b", "rear_a", "rear_b"};

BenchEffect row(const std::string& name, const std::string& caption, std::vector<BenchParameter> parameters,
                std::vector<std::string> experiments, std::function<void(const Values&, Changes&)> apply) {
  return {name, caption, false, std::move(parameters), std::move(experiments), std::move(apply)};
}

BenchEffect outside(const std::string& name, const std::string& caption, std::vector<BenchParameter> parameters,
                    std::function<void(const Values&, Changes&)> apply, std::vector<std::string> experiments = kLeap) {
  return {name, caption, true, std::move(parameters), std::move(experiments), std::move(apply)};
}

void add_transmission(std::vector<BenchEffect>& rows) {
  rows.push_back(row("tail_compliance", "the tail's shaft bends, in four pieces",
                     {{"compliance", "rad/(N m)", 0.0, 0.0005, 0.04}, {"damping_ratio", "-", 0.05, 0.0, 1.0}}, kTail,
                     [](const Values& v, Changes& c) {
                       if (v[0] == 0.0) return;
                       c.shaft_segments = 4;
                       c.shaft_stiffness = 1.0 / v[0];
                       c.shaft_damping_ratio = v[1];
                     }));
  rows.push_back(row("tail_backlash", "dead band behind the tail's gear", {{"play", "rad", 0.0, 0.001, 0.06}}, kTail,
                     [](const Values& v, Changes& c) { c.tail_play = v[0]; }));
  rows.push_back(row("tail_stop_restitution", "the tail bounces off its stop", {{"restitution", "-", 0.0, 0.05, 0.9}},
                     {"self_righting"}, [](const Values& v, Changes& c) { c.stop_restitution = v[0]; }));
}

void add_friction(std::vector<BenchEffect>& rows) {
  struct Group {
    const char* prefix;
    DryFriction Changes::*member;
    double torque;  ///< largest [N m]
    const std::vector<std::string>& experiments;
  };
  for (const Group& g :
       {Group{"tail", &Changes::tail_friction, 2.0, kTail}, Group{"leg", &Changes::leg_friction, 0.6, kLeap}}) {
    const auto member = g.member;
    const std::string prefix = g.prefix;
    const double largest = g.torque;
    rows.push_back(row(prefix + "_coulomb_friction", "dry friction in the joints",
                       {{"torque", "N m", 0.0, 0.005, largest}}, g.experiments,
                       [member](const Values& v, Changes& c) { (c.*member).coulomb = v[0]; }));
    rows.push_back(row(prefix + "_viscous_friction", "friction in proportion to speed",
                       {{"coefficient", "N m s/rad", 0.0, 0.0003, 0.1 * largest}}, g.experiments,
                       [member](const Values& v, Changes& c) { (c.*member).viscous = v[0]; }));
    rows.push_back(row(prefix + "_stribeck_friction", "stiction that fades with speed",
                       {{"torque", "N m", 0.0, 0.02, 2.0 * largest}, {"rate", "rad/s", 2.0, 0.2, 20.0}}, g.experiments,
                       [member](const Values& v, Changes& c) {
                         (c.*member).stribeck = v[0];
                         (c.*member).stribeck_rate = v[1];
                       }));
    rows.push_back(row(prefix + "_load_friction", "friction in proportion to the motor's torque",
                       {{"share", "-", 0.0, 0.005, 0.5}}, g.experiments,
                       [member](const Values& v, Changes& c) { (c.*member).load = v[0]; }));
  }
}

void add_actuation(std::vector<BenchEffect>& rows) {
  rows.push_back(row("actuation_delay", "commands wait in a buffer", {{"delay", "s", 0.0, 0.0001, 0.006}}, kTail,
                     [](const Values& v, Changes& c) { c.delay = v[0]; }));
  rows.push_back(row("late_start", "the plan starts late", {{"time", "s", 0.0, 0.00003, 0.02}}, kLeap,
                     [](const Values& v, Changes& c) { c.late_start = v[0]; }));
  rows.push_back(row("controller_gains", "the loop's gains are not those stated",
                     {{"proportional_scale", "-", 1.0, 0.0, 3.0}, {"derivative_scale", "-", 1.0, 0.0, 3.0}}, kLeap,
                     [](const Values& v, Changes& c) {
                       c.gain_p = v[0];
                       c.gain_d = v[1];
                     }));
  rows.push_back(row("torque_constant", "magnets stronger or weaker than stated", {{"scale", "-", 1.0, 0.6, 1.4}},
                     kTail, [](const Values& v, Changes& c) { c.torque_constant = v[0]; }));
  rows.push_back(row("voltage_limit", "the battery is flat", {{"shortfall", "-", 0.0, 0.002, 0.6}}, kTail,
                     [](const Values& v, Changes& c) { c.voltage_limit = 16.0 * (1.0 - v[0]); }));
  rows.push_back(row("current_limit", "drivers cut the current early", {{"shortfall", "-", 0.0, 0.02, 0.8}}, kTail,
                     [](const Values& v, Changes& c) { c.current_limit = 41.343 * (1.0 - v[0]); }));
  rows.push_back(row("battery_sag", "the battery has an internal resistance",
                     {{"resistance", "ohm", 0.0, 0.0005, 0.15}}, kTail,
                     [](const Values& v, Changes& c) { c.battery_resistance = v[0]; }));
  rows.push_back(row("winding_heating", "the windings are warm", {{"temperature", "K", 0.0, 2.0, 150.0}}, kTail,
                     [](const Values& v, Changes& c) { c.winding_rise = v[0]; }));
}

void add_air(std::vector<BenchEffect>& rows) {
  rows.push_back(row("drag_coefficient", "the scoop drags more or less", {{"scale", "-", 1.0, 0.0, 3.0}}, kTail,
                     [](const Values& v, Changes& c) { c.drag_coefficient = v[0]; }));
  rows.push_back(row("drag_without_translation", "drag as a couple by the tail's rotation alone",
                     {{"share", "-", 0.0, 1.0, 1.0}}, kMoving,
                     [](const Values& v, Changes& c) { c.drag_ignores_translation = v[0] > 0.0; }));
  rows.push_back(row("wind", "a fan", {{"speed", "m/s", 0.0, -4.0, 4.0}}, kTail,
                     [](const Values& v, Changes& c) { c.wind = v[0]; }));
}

void add_masses(std::vector<BenchEffect>& rows) {
  rows.push_back(row("tail_rotor_inertia", "a heavier rotor", {{"inertia", "kg m^2", 0.0, 1e-6, 3e-4}}, kTail,
                     [](const Values& v, Changes& c) { c.tail_rotor_inertia = v[0]; }));
  rows.push_back(row("leg_rotor_inertia", "heavier rotors", {{"inertia", "kg m^2", 0.0, 2e-6, 4e-4}}, kLeap,
                     [](const Values& v, Changes& c) { c.leg_rotor_inertia = v[0]; }));
  rows.push_back(row("tail_link_mass", "a heavier tail", {{"scale", "-", 1.0, 0.4, 2.0}}, kTail,
                     [](const Values& v, Changes& c) { c.tail_mass = v[0]; }));
  rows.push_back(row("tail_link_inertia", "tail spread wider about its centre of mass", {{"scale", "-", 1.0, 0.3, 3.0}},
                     kTail, [](const Values& v, Changes& c) { c.tail_inertia = v[0]; }));
  rows.push_back(row("leg_link_inertia", "leg links with other inertias", {{"scale", "-", 1.0, 0.3, 5.0}}, kLeap,
                     [](const Values& v, Changes& c) { c.leg_inertia = v[0]; }));
  rows.push_back(row("payload", "a mass on the body",
                     {{"mass", "kg", 0.0, 0.005, 2.0}, {"x", "m", 0.1, -0.25, 0.25}, {"z", "m", 0.05, -0.05, 0.15}},
                     kMoving, [](const Values& v, Changes& c) {
                       c.payload = v[0];
                       c.payload_place = {v[1], v[2]};
                     }));
  rows.push_back(row("com_shift", "the body's masses are elsewhere",
                     {{"x", "m", 0.0, -0.06, 0.06}, {"z", "m", 0.0, -0.05, 0.05}}, kMoving,
                     [](const Values& v, Changes& c) {
                       c.com_shift = {v[0], v[1]};
                     }));
  rows.push_back(row("body_inertia", "the body's masses are spread otherwise", {{"scale", "-", 1.0, 0.5, 2.0}}, kMoving,
                     [](const Values& v, Changes& c) { c.base_inertia = v[0]; }));
}

void add_contact_and_sensing(std::vector<BenchEffect>& rows) {
  rows.push_back(row("foot_friction", "a slippery floor", {{"scale", "-", 1.0, 0.25, 0.6}}, kLeap,
                     [](const Values& v, Changes& c) { c.floor_friction_scale = v[0]; }));
  rows.push_back(row("ground_compliance", "floor plates on springs",
                     {{"compliance", "m/N", 0.0, 3e-6, 3e-4}, {"damping_ratio", "-", 0.3, 0.0, 2.0}}, kLeap,
                     [](const Values& v, Changes& c) {
                       if (v[0] == 0.0) return;
                       c.floor_stiffness = 1.0 / v[0];
                       c.floor_damping_ratio = v[1];
                     }));
  rows.push_back(row("foot_radius", "round toes", {{"radius", "m", 0.0, 0.0005, 0.02}}, kLeap,
                     [](const Values& v, Changes& c) { c.toe_radius = v[0]; }));
  rows.push_back(row("tail_offset", "the tail's encoder is set wrong", {{"offset", "rad", 0.0, -0.15, 0.15}}, kLeap,
                     [](const Values& v, Changes& c) { c.joint_offset["tail"] = v[0]; }));
  rows.push_back(row("leg_offset", "leg encoders are set wrong",
                     {{"front", "rad", 0.0, -0.1, 0.1}, {"rear", "rad", 0.0, -0.1, 0.1}}, kLeap,
                     [](const Values& v, Changes& c) {
                       c.joint_offset["front_a"] = c.joint_offset["front_b"] = v[0];
                       c.joint_offset["rear_a"] = c.joint_offset["rear_b"] = v[1];
                     }));
  rows.push_back(row("sensor_latency", "sensors stamp late", {{"latency", "s", 0.0, 0.0001, 0.006}}, kTail,
                     [](const Values& v, Changes& c) { c.latency["mocap"] = c.latency["joints"] = v[0]; }));
  rows.push_back(row("sensor_scale", "motion capture measures lengths wrong", {{"scale", "-", 1.0, 0.85, 1.15}}, kLeap,
                     [](const Values& v, Changes& c) { c.scale["x"] = c.scale["z"] = v[0]; }));
}

void add_outside(std::vector<BenchEffect>& rows) {
  rows.push_back(outside("tether", "a cable behind the robot pulls once it is taut",
                         {{"stiffness", "N/m", 0.0, 5.0, 2000.0}, {"slack", "m", 0.02, 0.0, 0.1}},
                         [](const Values& v, Changes& c) {
                           c.outside.tether_stiffness = v[0];
                           c.outside.tether_slack = v[1];
                         }));
  rows.push_back(outside("torque_ripple", "leg motors cog", {{"amplitude", "N m", 0.0, 0.003, 0.5}},
                         [](const Values& v, Changes& c) { c.outside.ripple = v[0]; }));
  rows.push_back(outside("command_dropout", "one rear motor goes without torque for a while",
                         {{"duration", "s", 0.0, 0.002, 0.08}, {"start", "s", 0.06, 0.0, 0.15}},
                         [](const Values& v, Changes& c) {
                           c.outside.dropout = v[0];
                           c.outside.dropout_start = v[1];
                         }));
  rows.push_back(outside("sticky_floor", "the floor holds the rear feet down", {{"force", "N", 0.0, 2.0, 200.0}},
                         [](const Values& v, Changes& c) { c.outside.adhesion = v[0]; }));
  rows.push_back(outside(
      "tail_cable", "a bent cable at the tail's root, a spring that hardens",
      {{"stiffness", "N m/rad^3", 0.0, 0.05, 6.0}}, [](const Values& v, Changes& c) { c.outside.tail_cable = v[0]; },
      kTail));
  rows.push_back(outside("thermal_derating", "a front motor of one side loses a share of its torque mid-leap",
                         {{"share", "-", 0.0, 0.01, 1.0}, {"start", "s", 0.1, 0.0, 0.2}},
                         [](const Values& v, Changes& c) {
                           c.outside.derating = v[0];
                           c.outside.derating_start = v[1];
                         }));
  rows.push_back(
      outside("slipping_belt", "a rear motor of one side slips above a torque", {{"shortfall", "N m", 0.0, 0.05, 2.0}},
              [](const Values& v, Changes& c) { c.outside.belt_slip = v[0] > 0.0 ? 2.2 - v[0] : kInfinity; }));
  rows.push_back(outside("loose_battery", "the battery slides in the body", {{"mass", "kg", 0.0, 0.05, 2.5}},
                         [](const Values& v, Changes& c) { c.outside.loose_mass = v[0]; }));
  rows.push_back(outside("bent_leg", "one rear toe reaches further than the other",
                         {{"length", "m", 0.0, 0.0005, 0.02}},
                         [](const Values& v, Changes& c) { c.outside.bent_link = v[0]; }));
  rows.push_back(outside(
      "push", "a hand pushes the body once", {{"force", "N", 0.0, 2.0, 150.0}},
      [](const Values& v, Changes& c) { c.outside.push = v[0]; }, kMoving));
}

[[noreturn]] void refuse(const std::string& given, const std::string& why, const std::string& name,
                         const std::vector<std::string>& allowed) {
  const auto near = yaml::nearest_name(name, allowed);
  throw InputError(fmt::format("--effect {}: {}{}; allowed: {}", given, why,
                               near ? fmt::format(", did you mean '{}'?", *near) : "", fmt::join(allowed, ", ")));
}

double number_of(const std::string& given, const std::string& text, const BenchParameter& p) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code == std::errc() && end == text.data() + text.size() && value >= std::min(p.usual, p.lower) &&
      value <= std::max(p.usual, p.upper)) {
    return value;
  }
  throw InputError(fmt::format("--effect {}: {} '{}' given; allowed: a number from {} to {} {}", given, p.name, text,
                               std::min(p.usual, p.lower), std::max(p.usual, p.upper), p.unit));
}

}  // namespace

const std::vector<BenchEffect>& bench_effects() {
  static const std::vector<BenchEffect> all = [] {
    std::vector<BenchEffect> rows;
    add_transmission(rows);
    add_friction(rows);
    add_actuation(rows);
    add_air(rows);
    add_masses(rows);
    add_contact_and_sensing(rows);
    add_outside(rows);
    return rows;
  }();
  return all;
}

const BenchEffect* find_bench_effect(const std::string& name) {
  for (const BenchEffect& effect : bench_effects()) {
    if (effect.name == name) return &effect;
  }
  return nullptr;
}

std::vector<double> usual_values(const BenchEffect& effect) {
  std::vector<double> values;
  for (const BenchParameter& p : effect.parameters) values.push_back(p.usual);
  return values;
}

std::string bench_component(const std::string& effect) {
  const BenchEffect* found = find_bench_effect(effect);
  if (found == nullptr || found->outside || effect.starts_with("leg_")) return "";
  static const std::vector<std::pair<const char*, std::vector<std::string>>> parts = {
      {"tail_aerodynamics", {"drag_coefficient", "drag_without_translation", "wind"}},
      {"sensing", {"tail_offset", "sensor_latency", "sensor_scale"}},
      {"body", {"payload", "com_shift", "body_inertia"}},
      {"contact", {"foot_friction", "ground_compliance", "foot_radius"}}};
  for (const auto& [part, names] : parts) {
    if (std::find(names.begin(), names.end(), effect) != names.end()) return part;
  }
  return effect.starts_with("tail_") ? "tail_transmission" : "actuation";
}

void apply_effect(const std::string& given, Changes& changes) {
  const auto colon = given.find(':');
  const std::string name = given.substr(0, colon);
  const BenchEffect* effect = find_bench_effect(name);
  if (effect == nullptr) {
    std::vector<std::string> names;
    for (const BenchEffect& e : bench_effects()) names.push_back(e.name);
    refuse(given, fmt::format("unknown effect '{}'", name), name, names);
  }
  std::vector<std::string> names;
  Values values = usual_values(*effect);
  for (const BenchParameter& p : effect->parameters) names.push_back(p.name);
  std::vector<bool> seen(values.size(), false);
  std::string rest = colon == std::string::npos ? "" : given.substr(colon + 1);
  while (!rest.empty()) {
    const std::string part = rest.substr(0, rest.find(','));
    rest = rest.find(',') == std::string::npos ? "" : rest.substr(rest.find(',') + 1);
    const auto equals = part.find('=');
    const std::string key = part.substr(0, equals);
    const auto found = std::find(names.begin(), names.end(), key);
    if (found == names.end()) refuse(given, fmt::format("unknown parameter '{}'", key), key, names);
    const auto index = static_cast<std::size_t>(found - names.begin());
    if (seen[index]) throw InputError(fmt::format("--effect {}: '{}' stands twice; allowed: once", given, key));
    seen[index] = true;
    values[index] =
        number_of(given, equals == std::string::npos ? "" : part.substr(equals + 1), effect->parameters[index]);
  }
  if (std::find(seen.begin(), seen.end(), true) == seen.end()) {
    throw InputError(fmt::format("--effect {}: no value given; allowed: {}:{}=VALUE", given, name, names.front()));
  }
  effect->apply(values, changes);
}

}  // namespace jaculus::testbed
