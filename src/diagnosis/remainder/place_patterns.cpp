#include "diagnosis/remainder/place_patterns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "diagnosis/forward/missing_forces.h"
#include "diagnosis/remainder/pattern_file.h"

namespace jaculus::diagnosis {
namespace {

using model::PlanarModel;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kNearFloor = 5e-3;    ///< within which a foot feels the floor [m]
constexpr double kSmallTorque = 0.02;  ///< of the limit, where a dead band's step is
const std::vector<int> kWaves = {1, 2, 3, 4, 6, 8, 10, 12, 14, 16, 18, 20, 24, 28, 36};  ///< a turn
const std::vector<double> kHertz = {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0};
const std::vector<double> kSlacks = {0.02, 0.05, 0.1, 0.2};  ///< [m]

/// What an effect of the catalogue does at a joint: an offset of its torque, dry and viscous
/// friction, a scale, friction with load.
bool is_listed(const std::string& place, Regressor regressor) {
  const bool has_effect = regressor == Regressor::constant ||
                          regressor == Regressor::sign_of_speed || regressor == Regressor::speed ||
                          regressor == Regressor::motor_torque ||
                          regressor == Regressor::torque_friction;
  return place == "joint" && has_effect;
}

/// Lower-case letters, digits and _, as names of effects are.
std::string plain_name(std::string name) {
  for (char& c : name) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return "found_" + name;
}

/// A place with what its formulas call force and motion.
struct PatternPlace {
  std::string place, at, where;
  std::string key{};                ///< "torque", "force" of a joint
  std::string force{};              ///< unit
  std::string metre{};              ///< unit of its position
  std::string what{};               ///< of the captions: "torque at elbow"
  double large = 1.0;               ///< that counts as large, times the prior [force]
  double limit = 1.0;               ///< of a motor's torque, where it has one, else large [force]
  double speed = 1.0;               ///< usual [metre/s]
  double start = 0.0, range = 0.0;  ///< [metre]
};

class PatternMaker {
 public:
  explicit PatternMaker(PatternPlace place) : place_(std::move(place)) {}

  PlacePattern& add(Regressor regressor, const std::string& kind, const std::string& caption,
                    std::vector<PatternParameter> parameters, std::vector<std::string> formulas) {
    PlacePattern pattern{place_.place, place_.at, regressor};
    pattern.name = plain_name(place_.at + "_" + kind);
    pattern.caption = place_.what + " that " + caption;
    pattern.where = place_.where;
    pattern.parameters = std::move(parameters);
    pattern.formulas = std::move(formulas);
    pattern.listed = is_listed(place_.place, regressor);
    made.push_back(std::move(pattern));
    return made.back();
  }
  /// A parameter in units of force over `per`, whose usual size is `size`.
  [[nodiscard]] PatternParameter parameter(const std::string& name, const std::string& per = {},
                                           double size = 1.0) const {
    const std::string unit = per.empty() ? place_.force : fmt::format("{}/({})", place_.force, per);
    return {name, unit, place_.large / std::max(1e-9, size)};
  }
  [[nodiscard]] const PatternPlace& at() const { return place_; }

  std::vector<PlacePattern> made;

 private:
  PatternPlace place_;
};

/// A formula line of a joint.
std::string line(const PatternPlace& place, const std::string& formula) {
  return fmt::format("{}: \"{}\"\n", place.key, formula);
}

void add_waves(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  const double turn = place.metre == "rad" ? kTurn : 1.0;
  for (const int waves : kWaves) {
    const double period = turn / waves;
    if (period > 2.0 * place.range) continue;
    PlacePattern& wave = maker.add(
        Regressor::periodic, fmt::format("wave_{}", waves), "repeats with the joint's position",
        {maker.parameter("sine"), maker.parameter("cosine")},
        {line(place, "sine*sin(2*pi*q/period) + cosine*cos(2*pi*q/period)")});
    wave.period = period;
    wave.period_unit = place.metre;
  }
}

/// What may become of a motor's torque on its way, that is no share of it.
void add_losses(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  const std::string limit = constant_line("limit", place.force, place.limit);
  // As a force of the same prior at the limit, or after a second.
  const double lost = place.large / place.limit;
  const PatternParameter share{"share", "\"-\"", lost};
  const auto add = [&](const std::string& kind, const std::string& caption,
                       const std::string& cause, const PatternParameter& parameter,
                       const std::string& formula) {
    PlacePattern& pattern =
        maker.add(Regressor::motor_torque, kind, caption, {parameter}, {line(place, formula)});
    pattern.form = caption + ": " + cause;
    pattern.listed = false;
  };

  add("saturation", "is a share of the motor's that grows with it", "magnets saturate", share,
      "-share*abs(tau)*tau/limit");
  maker.made.back().constants = {limit};
  add("dead_band", "has the sign of the motor's", "a dead band", maker.parameter("level"),
      fmt::format("-level*tanh(tau/({}*limit))", kSmallTorque));
  maker.made.back().constants = {limit};
  add("fading", "is a share of the motor's that grows with time", "it fades", {"rate", "1/s", lost},
      "-rate*t*tau");
}

/// What a group's joints may have as well as one alone.
void add_joint(PatternMaker& maker, double rest_speed) {
  const PatternPlace& place = maker.at();
  const std::string rate = place.metre + "/s";
  const std::string rest =
      constant_line("rest", rate, std::max(1e-6, rest_speed * std::max(1e-3, place.speed)));
  const PatternParameter share{"share", "\"-\"", 0.1};

  maker.add(Regressor::constant, "offset", "is always there", {maker.parameter("offset")},
            {line(place, "offset")});
  maker
      .add(Regressor::sign_of_speed, "dry_friction", "acts against the motion",
           {maker.parameter("level")}, {line(place, "-level*tanh(qd/rest)")})
      .constants = {rest};
  maker.add(Regressor::speed, "damping", "grows with the speed",
            {maker.parameter("damping", rate, place.speed)}, {line(place, "-damping*qd")});
  maker.add(
      Regressor::speed_squared, "drag", "grows with the square of the speed",
      {maker.parameter("drag", fmt::format("{}^2/s^2", place.metre), place.speed * place.speed)},
      {line(place, "-drag*abs(qd)*qd")});
  maker.add(Regressor::motor_torque, "scale", "is a share of the motor's", {share},
            {line(place, "share*tau")});
  maker
      .add(Regressor::torque_friction, "load_friction",
           "is a share of the motor's, against the motion", {share},
           {line(place, "-share*abs(tau)*tanh(qd/rest)")})
      .constants = {rest};
  maker.add(Regressor::time, "drift", "grows with time since the start",
            {maker.parameter("rate", "s", 0.3)}, {line(place, "rate*t")});
  add_losses(maker);
  add_waves(maker);
}

void add_spring(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  maker
      .add(Regressor::position, "spring", "grows with the distance from where the joint starts",
           {maker.parameter("stiffness", place.metre, std::max(0.1, place.range))},
           {line(place, "-stiffness*(q - start)")})
      .constants = {constant_line("start", place.metre, place.start)};
}

/// "force: {x: ..., z: ...}".
std::string along(const std::string& axis, const std::string& formula, const std::string& none) {
  return axis == "x" ? fmt::format("force:\n  x: \"{}\"\n  z: \"{}\"\n", formula, none)
                     : fmt::format("force:\n  x: \"{}\"\n  z: \"{}\"\n", none, formula);
}

void add_body_axis(PatternMaker& maker, const std::string& axis) {
  const PatternPlace& place = maker.at();
  const std::string v = "v" + axis;
  const auto force = [&](const std::string& formula) {
    return std::vector<std::string>{along(axis, formula, "0*(" + formula + ")")};
  };
  const std::string start = constant_line("start", "m", place.start);

  maker.add(Regressor::constant, axis + "_offset", "is always there", {maker.parameter("offset")},
            force("offset"));
  maker
      .add(Regressor::position, axis + "_spring", "grows with the way from the start",
           {maker.parameter("stiffness", "m", std::max(0.05, place.range))},
           force("-stiffness*(" + axis + " - start)"))
      .constants = {start};
  if (axis == "x")
    for (const double slack : kSlacks) {
      if (slack > place.range) continue;
      PlacePattern& cable =
          maker.add(Regressor::position, fmt::format("x_cable_{:.0f}_mm", 1e3 * slack),
                    "grows with the way once a cable is taut",
                    {maker.parameter("stiffness", "m", std::max(0.05, place.range - slack))},
                    force("-stiffness*max(0, x - start - slack)"));
      cable.constants = {start};
      cable.slack = slack;
    }

  maker.add(Regressor::speed, axis + "_damping", "grows with the speed",
            {maker.parameter("damping", "m/s", place.speed)}, force("-damping*" + v));
  maker.add(Regressor::speed_squared, axis + "_drag", "grows with the square of the speed",
            {maker.parameter("drag", "m^2/s^2", place.speed * place.speed)},
            force("-drag*abs(" + v + ")*" + v));
  maker.add(Regressor::time, axis + "_drift", "grows with time since the start",
            {maker.parameter("rate", "s", 0.3)}, force("rate*t"));
  for (const double hertz : kHertz) {
    PlacePattern& wave =
        maker.add(Regressor::periodic_in_time, fmt::format("{}_sway_{:.0f}_mhz", axis, 1e3 * hertz),
                  "repeats in time", {maker.parameter("sine"), maker.parameter("cosine")},
                  force("sine*sin(2*pi*t/period) + cosine*cos(2*pi*t/period)"));
    wave.period = 1.0 / hertz;
    wave.period_unit = "s";
  }
}

void add_moment(PatternMaker& maker) {
  const auto moment = [](const std::string& formula) {
    return std::vector<std::string>{fmt::format("moment: \"{}\"\n", formula)};
  };
  maker.add(Regressor::constant, "pitch_offset", "is always there", {maker.parameter("offset")},
            moment("offset"));
  maker.add(Regressor::speed, "pitch_damping", "grows with the speed",
            {maker.parameter("damping", "rad/s", maker.at().speed)}, moment("-damping*omega"));
}

void add_foot(PatternMaker& maker, double rest_speed) {
  const PatternPlace& place = maker.at();
  const std::string near = "max(0, min(1, 1 - z/range))",
                    range = constant_line("range", "m", kNearFloor);
  const auto force = [&](const std::string& axis, const std::string& formula) {
    return std::vector<std::string>{along(axis, formula, "0*(" + formula + ")")};
  };
  maker
      .add(Regressor::constant, "held", "holds it to the floor", {maker.parameter("level")},
           force("z", "-level*" + near))
      .constants = {range};
  maker
      .add(Regressor::constant, "pulled", "pulls along the floor", {maker.parameter("level")},
           force("x", "level*" + near))
      .constants = {range};
  maker
      .add(Regressor::position, "reach", "pushes it off from a height on",
           {maker.parameter("stiffness", "m", kNearFloor)},
           force("z", "stiffness*max(0, range - z)"))
      .constants = {range};
  maker
      .add(Regressor::sign_of_speed, "rub", "acts against its motion along the floor",
           {maker.parameter("level")}, force("x", "-level*tanh(vx/rest)*" + near))
      .constants = {range, constant_line("rest", "m/s", std::max(1e-6, rest_speed * place.speed))};
}

PatternPlace joint_place(const PlanarModel& robot, const model::PlanarMotor& motor,
                         const UsualMotion& usual, double prior, double lever) {
  const int m = robot.motor_index(motor.joint);
  const bool turns = robot.bodies[motor.body].kind == model::JointKind::revolute;
  PatternPlace place{"joint", motor.joint, "{joint: " + motor.joint + "}"};
  place.key = turns ? "torque" : "force";
  place.force = turns ? "N m" : "N";
  place.metre = turns ? "rad" : "m";
  place.what = place.key + " at " + motor.joint;
  place.limit = large_force(robot, motor, lever);
  place.large = prior * place.limit;
  place.speed = std::max(1e-3, usual.motors.speed[m]);
  place.start = usual.motors.start[m];
  place.range = usual.motors.range[m];
  return place;
}

void add_all(const PatternMaker& maker, std::vector<PlacePattern>& all) {
  all.insert(all.end(), maker.made.begin(), maker.made.end());
}

void add_joints(const PlanarModel& robot, const UsualMotion& usual, double prior, double lever,
                double rest_speed, std::vector<PlacePattern>& all) {
  std::vector<PatternPlace> legs;
  for (const model::PlanarMotor& motor : robot.motors) {
    PatternMaker maker(joint_place(robot, motor, usual, prior, lever));
    add_joint(maker, rest_speed);
    add_spring(maker);
    add_all(maker, all);
    if (maker.at().place == "joint" && !robot.feet.empty() && maker.at().metre == "rad")
      legs.push_back(maker.at());
  }
  if (legs.size() < 2) return;
  // The sizes of the motor that moves farthest are theirs.
  PatternPlace together = *std::max_element(
      legs.begin(), legs.end(),
      [](const PatternPlace& a, const PatternPlace& b) { return a.range < b.range; });
  together.at = "legs";
  together.where = "{group: legs}";
  together.what = "torque at every leg's joints";
  PatternMaker maker(together);
  add_joint(maker, rest_speed);
  add_all(maker, all);
}

void add_body(const PlanarModel& robot, const UsualMotion& usual, double prior, double lever,
              std::vector<PlacePattern>& all) {
  const double weight = robot.total_mass() * robot.gravity;
  const model::PlanarBody& base = robot.bodies.front();
  for (const std::string axis : {"x", "z", "pitch"}) {
    const int c = robot.coordinate_index(axis);
    if (c < 0) continue;
    PatternPlace place{"body", axis,
                       fmt::format("{{body: {}, point: [{:.6g}, {:.6g}]}}", base.name, base.com.x(),
                                   base.com.y())};
    const bool turns = axis == "pitch";
    place.force = turns ? "N m" : "N";
    place.metre = turns ? "rad" : "m";
    place.what = turns ? "moment on the body" : "force on the body along " + axis;
    place.large = prior * weight * (turns ? lever : 1.0);
    place.speed = std::max(1e-3, usual.coordinates.speed[c]);
    place.start = usual.coordinates.start[c];
    place.range = usual.coordinates.range[c];
    PatternMaker maker(place);
    turns ? add_moment(maker) : add_body_axis(maker, axis);
    add_all(maker, all);
  }
}

void add_feet(const PlanarModel& robot, const UsualMotion& usual, double prior, double rest_speed,
              std::vector<PlacePattern>& all) {
  const double weight = robot.total_mass() * robot.gravity;
  const int x = robot.coordinate_index("x");
  for (const model::PlanarPoint& foot : robot.feet) {
    PatternPlace place{"feet", foot.name, "{point: " + foot.name + "}"};
    place.force = "N";
    place.metre = "m";
    place.what = "force at " + foot.name;
    place.large = prior * weight;
    place.speed = x < 0 ? 1.0 : std::max(1e-3, usual.coordinates.speed[x]);
    PatternMaker maker(place);
    add_foot(maker, rest_speed);
    add_all(maker, all);
  }
}

}  // namespace

std::vector<PlacePattern> place_patterns(const PlanarModel& robot, const UsualMotion& usual,
                                         double prior, double lever, double rest_speed) {
  std::vector<PlacePattern> all;
  add_joints(robot, usual, prior, lever, rest_speed, all);
  add_body(robot, usual, prior, lever, all);
  add_feet(robot, usual, prior, rest_speed, all);
  return all;
}

}  // namespace jaculus::diagnosis
