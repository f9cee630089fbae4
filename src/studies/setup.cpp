#include "studies/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace jaculus::studies {
namespace {

using Setup = ReorientationSetup;

constexpr Bounds kFraction{1e-9, 1.0 - 1e-9};
constexpr Bounds kAny{-1e12, 1e12};

// Unsets the other one of a pair.
template <double Setup::*Member, double Setup::*Other>
void set_instead(Setup& s, double v) {
  s.*Member = v;
  s.*Other = kNaN;
}
template <double Setup::*Member>
void set_member(Setup& s, double v) {
  s.*Member = v;
}
template <double Setup::*Member>
double get_member(const Setup& s) {
  return s.*Member;
}
template <double model::PlanarMotor::*Member>
void set_motor(Setup& s, double v) {
  s.motor.*Member = v;
}
template <double model::PlanarMotor::*Member>
double get_motor(const Setup& s) {
  return s.motor.*Member;
}

template <double Setup::*Member>
Parameter plain(const char* name, const char* column, Dimension d, Bounds allowed,
                const char* meaning) {
  return {name, column, d, allowed, get_member<Member>, set_member<Member>, meaning};
}
template <double Setup::*Member, double Setup::*Other>
Parameter one_of(const char* name, const char* column, Dimension d, Bounds allowed,
                 const char* meaning) {
  return {name, column, d, allowed, get_member<Member>, set_instead<Member, Other>, meaning};
}
template <double model::PlanarMotor::*Member>
Parameter of_motor(const char* name, const char* column, Dimension d, Bounds allowed,
                   const char* meaning) {
  return {name, column, d, allowed, get_motor<Member>, set_motor<Member>, meaning};
}

const std::vector<std::pair<std::string, std::string>>& alternatives() {
  static const std::vector<std::pair<std::string, std::string>> pairs{
      {"tail.inertia", "tail.normalised_inertia"},
      {"tail.shaft", "tail.shaft_ratio"},
      {"task.drop", "task.duration"}};
  return pairs;
}

// s^3.5 motors side by side behind s^(1/2) the gear; each carries its share of the torque.
model::PlanarMotor similar_motor(model::PlanarMotor m, double s) {
  const double motors = std::pow(s, 3.5);
  m.gear *= std::sqrt(s);
  m.saturation_linear /= motors;
  m.saturation_cubic /= motors * motors * motors;
  m.torque_limit *= motors;
  return m;
}

// body.*, tail.*: masses, lengths, drag.
std::vector<Parameter> body_and_tail_parameters() {
  namespace dim = dimension;
  using S = Setup;

  return {
      plain<&S::body_inertia>("body.inertia", "body_inertia_kg_m2", dim::inertia, kPositive,
                              "body's inertia about the pin"),
      plain<&S::body_mass>("body.mass", "body_mass_kg", dim::mass, kPositive,
                           "for the share of mass that a tail adds"),
      one_of<&S::tail_inertia, &S::normalised_inertia>("tail.inertia", "tail_inertia_kg_m2",
                                                       dim::inertia, kPositive,
                                                       "tail's inertia about the pin"),
      one_of<&S::normalised_inertia, &S::tail_inertia>("tail.normalised_inertia",
                                                       "normalised_inertia", dim::none, kFraction,
                                                       "tail's share of both inertias"),
      plain<&S::tail_length>("tail.length", "tail_length_m", dim::length, kPositive, "pin to tip"),
      one_of<&S::tail_shaft, &S::shaft_ratio>("tail.shaft", "tail_shaft_m", dim::length,
                                              kNotNegative, "pin to where drag begins"),
      one_of<&S::shaft_ratio, &S::tail_shaft>("tail.shaft_ratio", "shaft_ratio", dim::none,
                                              {0.0, 1.0}, "shaft over length"),
      plain<&S::tail_width>("tail.width", "tail_width_m", dim::length, kNotNegative,
                            "width across the flow"),
      plain<&S::drag_coefficient>("tail.drag_coefficient", "drag_coefficient", dim::none,
                                  kNotNegative, "C_D"),
      plain<&S::tail_mass>("tail.mass", "tail_mass_kg", dim::mass, kPositive,
                           "for the torque that holds it level"),
      plain<&S::framing_mass>("tail.framing_mass", "framing_mass_kg", dim::mass, kNotNegative,
                              "of motor and mount, for the share of mass that a tail adds"),
      plain<&S::tail_com>("tail.com", "tail_com_m", dim::length, kNotNegative,
                          "centre of mass, from the pin"),
      plain<&S::initial_tail_angle>("tail.initial_angle", "initial_tail_angle_rad", dim::angle,
                                    kAny,
                                    "in the world: 0 up, positive forward; matters in wind only"),
      plain<&S::root_stiffness>("tail.root_stiffness", "root_stiffness_N_m_rad",
                                dim::angular_stiffness, kPositive,
                                "torsion spring between motor and tail; absent: rigid"),
  };
}

// air.*
std::vector<Parameter> air_parameters() {
  namespace dim = dimension;
  using S = Setup;

  return {
      plain<&S::air_density>("air.density", "air_density_kg_m3", dim::density, kNotNegative, "rho"),
      plain<&S::wind_forward>("air.wind", "wind_m_s", dim::velocity, kAny,
                              "velocity of the air along +x"),
  };
}

// motor.*
std::vector<Parameter> motor_parameters() {
  namespace dim = dimension;
  using M = model::PlanarMotor;

  return {
      of_motor<&M::torque_constant>("motor.torque_constant", "torque_constant_N_m_A",
                                    dim::torque_constant, kPositive, "k_t"),
      of_motor<&M::resistance>("motor.resistance", "resistance_ohm", dim::resistance, kPositive,
                               "winding"),
      of_motor<&M::saturation_linear>("motor.saturation_linear", "saturation_linear_A_N_m",
                                      dim::saturation_linear, kPositive, "a of i = a t + c t^3"),
      of_motor<&M::saturation_cubic>("motor.saturation_cubic", "saturation_cubic_A_N_m3",
                                     dim::saturation_cubic, kNotNegative, "c of i = a t + c t^3"),
      of_motor<&M::voltage>("motor.voltage", "voltage_V", dim::voltage, kPositive,
                            "applied from the start"),
      of_motor<&M::gear>("motor.gear", "gear", dim::none, kPositive, "motor turns a joint turn"),
      of_motor<&M::efficiency>("motor.efficiency", "efficiency", dim::none, {1e-3, 1.0},
                               "of the gear"),
      of_motor<&M::current_limit>("motor.current_limit", "current_limit_A", dim::current, kPositive,
                                  "of the driver"),
      of_motor<&M::torque_limit>("motor.torque_limit", "torque_limit_N_m", dim::torque, kPositive,
                                 "before the gear"),
  };
}

// task.*, scaling.*
std::vector<Parameter> task_parameters() {
  namespace dim = dimension;
  using S = Setup;

  return {
      one_of<&S::drop, &S::duration>("task.drop", "drop_m", dim::length, kPositive,
                                     "height of the fall"),
      one_of<&S::duration, &S::drop>("task.duration", "duration_s", dim::time, kPositive,
                                     "in place of drop"),
      plain<&S::stroke>("task.stroke", "stroke_rad", dim::angle, {1e-6, 100.0},
                        "tail angle at the stop"),
      plain<&S::target>("task.target", "target_rad", dim::angle, {1e-6, 100.0},
                        "body rotation to be timed"),
      plain<&S::forward_speed>("task.forward_speed", "forward_speed_m_s", dim::velocity, kAny,
                               "of the body"),
      plain<&S::climb_speed>("task.climb_speed", "climb_speed_m_s", dim::velocity, kAny,
                             "of the body, upwards"),
      plain<&S::scale>("scaling.factor", "scale", dim::none, {1e-4, 1e4}, "of all lengths"),
  };
}

}  // namespace

const std::vector<Parameter>& setup_parameters() {
  static const std::vector<Parameter> table = [] {
    std::vector<Parameter> all = body_and_tail_parameters();
    for (const auto& group : {air_parameters(), motor_parameters(), task_parameters()})
      all.insert(all.end(), group.begin(), group.end());
    return all;
  }();
  return table;
}

const std::vector<Option>& setup_options() {
  static const std::vector<Option> table{
      {"tail.drag",
       {"rotation", "distributed", "none"},
       [](Setup& s, const std::string& v) {
         s.drag = v == "none" ? model::DragKind::none
                              : (v == "rotation" ? model::DragKind::rotation
                                                 : model::DragKind::distributed);
       },
       "equation 2, equation 8 (feels the body's speed and the wind), or none"},
      {"motor.limits",
       {"ignored", "applied"},
       [](Setup& s, const std::string& v) { s.motor_limits = v == "applied"; },
       "whether current_limit and torque_limit hold the torque back"},
      {"scaling.tail",
       {"isometric", "fixed_width", "fixed_tail"},
       [](Setup& s, const std::string& v) {
         s.tail_scaling = v == "isometric"     ? TailScaling::isometric
                          : v == "fixed_width" ? TailScaling::fixed_width
                                               : TailScaling::fixed_tail;
       },
       "what of the tail grows with the body"},
      {"scaling.motor",
       {"fixed", "similar"},
       [](Setup& s, const std::string& v) {
         s.motor_scaling = v == "fixed" ? MotorScaling::fixed : MotorScaling::similar;
       },
       "the same motor, or one of dynamically similar strength"},
  };

  return table;
}

const Parameter& find_parameter(const std::string& name, const yaml::Node& where) {
  std::vector<std::string> names;
  for (const Parameter& p : setup_parameters()) {
    if (p.name == name) return p;
    names.push_back(p.name);
  }
  const auto near = yaml::nearest_name(name, names);
  throw where.error(fmt::format("there is no number \"{}\" to turn{}", name,
                                near ? fmt::format("; did you mean \"{}\"?", *near)
                                     : fmt::format("; there are {}", fmt::join(names, ", "))));
}

void set_from(ReorientationSetup& setup, const std::string& name, const yaml::Node& value) {
  for (const Option& option : setup_options()) {
    if (option.name == name) return option.set(setup, value.choice(option.choices));
  }
  const Parameter& p = find_parameter(name, value);
  p.set(setup, value.number(p.dimension, p.allowed));
}

ReorientationSetup read_setup(const yaml::Node& base) {
  std::map<std::string, std::vector<std::string>> keys;
  const auto add = [&](const std::string& name) {
    const auto dot = name.find('.');
    keys[name.substr(0, dot)].push_back(name.substr(dot + 1));
  };
  for (const Parameter& p : setup_parameters()) add(p.name);
  for (const Option& o : setup_options()) add(o.name);

  std::vector<std::string> groups;
  for (const auto& [group, unused] : keys) groups.push_back(group);
  base.only(groups);

  for (const auto& [a, b] : alternatives()) {
    const auto dot = a.find('.');
    const auto group = base.find(a.substr(0, dot));
    if (group && group->has(a.substr(dot + 1)) && group->has(b.substr(dot + 1))) {
      throw group->error(fmt::format("{} and {} are given; they say the same, so give one", a, b));
    }
  }

  ReorientationSetup setup;
  for (const auto& [group, node] : base.entries()) {
    node.only(keys[group]);
    for (const auto& [key, value] : node.entries())
      set_from(setup, fmt::format("{}.{}", group, key), value);
  }
  return setup;
}

namespace {

/// A mass of centre of mass c between the pin and the tip at L has an inertia of m c^2 to m c L
/// about the pin.
std::string check_mass(const ReorientationSetup& s) {
  if (std::isnan(s.tail_mass) || std::isnan(s.tail_com)) return "";

  const double share = s.normalised_inertia;
  const double inertia =
      std::isnan(share) ? s.tail_inertia : s.body_inertia * share / (1.0 - share);

  const double least = s.tail_mass * s.tail_com * s.tail_com;
  if (inertia < least * (1.0 - 1e-9)) {
    return fmt::format(
        "tail.inertia is {:.4g} kg m^2; {:.4g} kg at {:.4g} m (tail.mass, tail.com) have {:.4g} or "
        "more",
        inertia, s.tail_mass, s.tail_com, least);
  }

  const double most = s.tail_mass * s.tail_com * s.tail_length;
  if (!std::isnan(s.tail_length) && inertia > most * (1.0 + 1e-9)) {
    return fmt::format(
        "tail.inertia is {:.4g} kg m^2; {:.4g} kg at {:.4g} m (tail.mass, tail.com) on {:.4g} m "
        "have {:.4g} or less",
        inertia, s.tail_mass, s.tail_com, s.tail_length, most);
  }

  return "";
}

}  // namespace

std::string check_setup(const ReorientationSetup& s) {
  struct Need {
    const char* name;
    bool given;
  };

  const auto has = [](double v) { return !std::isnan(v); };
  const bool drag = s.drag != model::DragKind::none;
  for (const Need& need :
       {Need{"body.inertia", has(s.body_inertia)},
        Need{"tail.inertia (or tail.normalised_inertia)",
             has(s.tail_inertia) || has(s.normalised_inertia)},
        Need{"tail.length", !drag || has(s.tail_length)},
        Need{"tail.shaft (or tail.shaft_ratio)", !drag || has(s.tail_shaft) || has(s.shaft_ratio)},
        Need{"tail.width", !drag || has(s.tail_width)},
        Need{"tail.drag_coefficient", !drag || has(s.drag_coefficient)},
        Need{"air.density", !drag || has(s.air_density)},
        Need{"motor.torque_constant", s.motor.torque_constant > 0.0},
        Need{"motor.resistance", s.motor.resistance > 0.0},
        Need{"motor.saturation_linear", s.motor.saturation_linear > 0.0},
        Need{"motor.voltage", s.motor.voltage > 0.0},
        Need{"task.drop (or task.duration)", has(s.drop) || has(s.duration)},
        Need{"task.stroke", has(s.stroke)}, Need{"task.target", has(s.target)}}) {
    if (!need.given) return fmt::format("{} is missing", need.name);
  }

  const bool moving = s.forward_speed != s.wind_forward || s.climb_speed != 0.0;
  if (moving && s.drag == model::DragKind::rotation) {
    return "tail.drag: rotation does not feel the air's motion; take \"distributed\" with a speed "
           "or wind";
  }

  const std::string fault = check_case(to_case(s));
  return fault.empty() ? check_mass(s) : fault;
}

ReorientationCase to_case(const ReorientationSetup& s) {
  const double k = s.scale;
  const double fifth = std::pow(k, 5);
  const bool tail_grows = s.tail_scaling != TailScaling::fixed_tail;

  ReorientationCase c;
  c.body_inertia = s.body_inertia * fifth;
  const double share = s.normalised_inertia;
  c.tail_inertia = (std::isnan(share) ? s.tail_inertia : s.body_inertia * share / (1.0 - share)) *
                   (tail_grows ? fifth : 1.0);

  c.motor = s.motor_scaling == MotorScaling::similar ? similar_motor(s.motor, k) : s.motor;
  c.motor_limits = s.motor_limits;
  c.drag.name = "tail";
  c.drag.kind = s.drag;
  c.drag.density = std::isnan(s.air_density) ? 0.0 : s.air_density;
  const auto or_zero = [](double v) { return std::isnan(v) ? 0.0 : v; };

  c.drag.coefficient = or_zero(s.drag_coefficient);
  c.drag.width = or_zero(s.tail_width) * (s.tail_scaling == TailScaling::isometric ? k : 1.0);
  c.drag.end = or_zero(s.tail_length) * (tail_grows ? k : 1.0);
  c.drag.start = std::isnan(s.shaft_ratio) ? or_zero(s.tail_shaft) * (tail_grows ? k : 1.0)
                                           : s.shaft_ratio * c.drag.end;

  c.drag.wind_W = Vec2(s.wind_forward, 0.0);
  c.pivot_velocity = Vec2(s.forward_speed, s.climb_speed);
  c.initial_tail_angle = s.initial_tail_angle;

  c.stroke = s.stroke;
  c.duration = std::isnan(s.duration) ? fall_time(s.drop * k) : s.duration;
  c.target_angle = s.target;
  c.root_stiffness = s.root_stiffness;

  return c;
}

double hold_torque(const ReorientationSetup& s) { return s.tail_mass * kGravity * s.tail_com; }

}  // namespace jaculus::studies
