#include "jaculus/model/unusual.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "jaculus/core/units.h"
#include "model/fields.h"

namespace jaculus::model {
namespace {

/// What a value of this key usually is, whatever the robot; zero, where it is allowed, means that
/// the thing isn't there and is never told.
struct Usual {
  std::string_view key;  ///< last part of a value's path
  Bounds range;          ///< [SI]
  std::string_view why;
};

constexpr Usual kUsual[] = {
    // Wong, Theory of Ground Vehicles: tyres on ice 0.1, on dry asphalt 0.9. Soft clean rubber on
    // glass reaches 2 and more.
    {"friction",
     {0.05, 2.0},
     "usual: 0.1 (rubber on ice) to 1 (on dry concrete); racing tyres reach 2"},
    // From the Moon's 1.62 to Jupiter's 24.8.
    {"gravity", {1.6, 25.0}, "usual: 9.81 m/s^2 on Earth, 1.62 on the Moon, 3.71 on Mars"},
    // A cell has 1 V; rectified three-phase mains of 400 V give 565 V, electric cars have 800 V.
    {"voltage", {1.0, 1000.0}, "usual: 3 to 60 V of batteries, up to 565 V of mains"},
    // Catalogues of brushed and brushless motors from 1 W to 10 kW.
    {"resistance", {1e-3, 1e3}, "usual: some milliohms to 100 ohm for motors of 10 kW to 1 W"},
    // Starter motors of cars take 500 to 1000 A.
    {"current_limit", {1e-3, 1e3}, "usual: up to 300 A; 1000 A turn a lorry's engine over"},
    // Planetary gears of four stages, 1:1000, are the largest in catalogues of small motors.
    {"gear", {0.05, 2000.0}, "usual: 1 to 300; turns of the motor for one of the joint"},
    // Worm gears of one start hold themselves below 0.5 and end near 0.3.
    {"efficiency", {0.2, 1.0}, "usual: 0.6 to 0.98; worm gears have 0.3"},
    // A solid rotor of 10 kg and 14 cm radius, m r^2/2.
    {"rotor_inertia",
     {1e-10, 0.1},
     "usual: 1e-7 (some grams) to 1e-3 kg m^2; 0.1 is a rotor of 10 kg"},
    // Air at 8 km and -40 degrees has 0.5, at sea level and -40 degrees 1.5.
    {"density", {0.5, 1.6}, "usual: 1.2 kg/m^3, air at sea level; water has 1000"},
    // Hoerner, Fluid-Dynamic Drag: a long plate across the flow 2.0, a half-cylinder open to it
    // 2.3.
    {"coefficient", {0.0, 5.0}, "usual: 1 to 2.3 for plates and scoops across the flow"},
};

/// Joint torque that a robot on legs may have, over its weight times its reach [-]: robots that
/// leap have about one (src/cli/robot_doubts.cpp).
constexpr double kMostMeasures = 10.0;
/// Of any joint [N m]: axes of the heaviest industrial arms.
constexpr double kMostTorque = 1e4;
/// Of any joint that slides [N]: a hydraulic cylinder of 20 cm bore at 350 bar.
constexpr double kMostForce = 1.1e6;
/// Turning rate of a motor without load, V/k_t [rad/s]: the fastest small turbines and spindles
/// turn 125,000 times a minute, a direct drive's motor ten times.
constexpr Bounds kNoLoad{1.0, 1.3e4};
/// [kg/m^3] Tungsten and gold have 19,300.
constexpr double kDensest = 2e4;

std::string told(const std::string& path, double value, const std::string& unit,
                 std::string_view why) {
  return fmt::format("{} = {:.4g}{}; {}", path, value, after_number(unit), why);
}

void add_by_key(PlanarModel model, std::vector<std::string>& out) {
  for (const Field& field : model_fields(model)) {
    const auto* number = std::get_if<double*>(&field.target);
    if (number == nullptr || **number == 0.0 || std::isinf(**number)) continue;
    for (const Usual& usual : kUsual)
      if (field.key() == usual.key && !usual.range.contains(**number))
        out.push_back(told(field.path, **number, unit_name(field.dimension), usual.why));
  }
}

/// Reach of a body from its joint: to its centre of mass and to what it carries [m].
double length_of(const PlanarModel& model, int body) {
  double length = model.bodies[body].com.norm();
  for (const PlanarBody& other : model.bodies)
    if (other.parent == body) length = std::max(length, other.origin.norm());
  for (const auto* points : {&model.feet, &model.points})
    for (const PlanarPoint& point : *points)
      if (point.body == body) length = std::max(length, point.position.norm());
  for (const PlanarDrag& drag : model.drags)
    if (drag.body == body) length = std::max(length, drag.end);
  return length;
}

double reach_of(const PlanarModel& model) {
  double reach = 0.0;
  for (int b = 0; b < count_of(model.bodies); ++b) reach += length_of(model, b);
  return reach;
}

/// A ball that is as large as the body is long, or that has its inertia, is denser than any metal.
void add_densities(const PlanarModel& model, std::vector<std::string>& out) {
  for (int b = 0; b < count_of(model.bodies); ++b) {
    const PlanarBody& body = model.bodies[b];
    if (!(body.mass > 0.0)) continue;
    // 2/5 m r^2 of a ball; the inertia is that of `count` bodies, as the mass is.
    const double of_inertia = 2.0 * std::sqrt(2.5 * body.inertia / body.mass);
    const double size = std::max(length_of(model, b), of_inertia);
    const double density = body.mass / body.count / (std::numbers::pi / 6.0 * std::pow(size, 3));
    if (!(density > kDensest)) continue;
    out.push_back(told(
        "bodies." + body.name + ".mass", body.mass, "kg",
        fmt::format("in a body of {:.2g} m by its lengths and its inertia of {:.2g} kg m^2, as a "
                    "ball {:.2g} kg/m^3; usual: 100 to 3000, tungsten has 19,300",
                    size, body.inertia, density)));
  }
}

void add_torques(const PlanarModel& model, std::vector<std::string>& out) {
  const bool moves = model.base_free[0] && model.base_free[1];
  constexpr double kEarth = 9.81;  // [m/s^2]
  const double measure = model.total_mass() * kEarth * reach_of(model);
  for (const PlanarMotor& motor : model.motors) {
    const bool slides = model.slides(motor);
    const double torque = motor.torque_limit * motor.gear * motor.efficiency;
    if (std::isinf(torque)) continue;
    const std::string path = "motors." + motor.joint + ".torque_limit";
    if (slides && torque > kMostForce)
      out.push_back(told(path, motor.torque_limit, "N",
                         "usual: up to 1e4 N; a hydraulic cylinder of 20 cm bore gives 1.1e6"));
    if (slides) continue;

    const std::string unit =
        motor.gear == 1.0 ? "N m" : fmt::format("N m times gear {:.4g}", motor.gear);
    if (torque > kMostTorque)
      out.push_back(
          told(path, motor.torque_limit, unit,
               "usual: up to 500 N m at the joint; the largest industrial arms have 1e4"));
    else if (moves && measure > 0.0 && torque > kMostMeasures * measure)
      out.push_back(told(path, motor.torque_limit, unit,
                         fmt::format("{:.2g} times this robot's weight times its reach; usual: "
                                     "about 1 for robots that leap",
                                     torque / measure)));
  }
}

void add_no_load_speeds(const PlanarModel& model, std::vector<std::string>& out) {
  for (const PlanarMotor& motor : model.motors) {
    if (motor.ideal() || !(motor.torque_constant > 0.0)) continue;
    const double speed = motor.voltage / motor.torque_constant;
    if (kNoLoad.contains(speed)) continue;
    out.push_back(told(
        "motors." + motor.joint + ".torque_constant", motor.torque_constant, "N m/A",
        fmt::format("at {:.4g} V the motor would turn at {:.2g} rad/s without load; usual: 10 to "
                    "5000 rad/s",
                    motor.voltage, speed)));
  }
}

}  // namespace

std::vector<std::string> unusual_values(const PlanarModel& model) {
  std::vector<std::string> out;
  add_by_key(model, out);
  add_densities(model, out);
  add_torques(model, out);
  add_no_load_speeds(model, out);
  return out;
}

}  // namespace jaculus::model
