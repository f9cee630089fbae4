// The testbed's effects in joints and drives.

#include "jaculus/trajectory/dataset.h"
#include "testbed/effect_rows.h"

namespace jaculus::testbed {
namespace {

using Kind = trajectory::ExperimentKind;

/// Joints that share their friction, and how strong it may be as shares of the motors' torque.
struct FrictionGroup {
  std::string prefix;
  std::string component;
  DryFriction Changes::*member;
  const MotorSizes& motors;
  const Experiments& experiments;
  double largest, least;        ///< Coulomb torque [-]
  double least_viscous;         ///< coefficient [s/rad]
  double least_stribeck = 0.0;  ///< [-]
};

void add_friction(EffectRows& rows, const FrictionGroup& g) {
  if (g.motors.joints.empty()) return;
  const auto member = g.member;
  const double torque = g.motors.torque, largest = round_figure(g.largest * torque);

  rows.add(g.prefix + "_coulomb_friction", "dry friction in the joints", g.component,
           {strength("torque", "N m", g.least * torque, largest)}, g.experiments,
           [member](const Values& v, Changes& c) { (c.*member).coulomb = v[0]; });
  rows.add(g.prefix + "_viscous_friction", "friction in proportion to speed", g.component,
           {strength("coefficient", "N m s/rad", g.least_viscous * torque, 0.1 * largest)},
           g.experiments, [member](const Values& v, Changes& c) { (c.*member).viscous = v[0]; });
  rows.add(g.prefix + "_stribeck_friction", "stiction that fades with speed", g.component,
           {strength("torque", "N m", g.least_stribeck * torque, 2.0 * largest),
            {"rate", "rad/s", 2.0, 0.2, 20.0}},
           g.experiments, [member](const Values& v, Changes& c) {
             (c.*member).stribeck = v[0];
             (c.*member).stribeck_rate = v[1];
           });
  rows.add(g.prefix + "_load_friction", "friction in proportion to the motor's torque", g.component,
           {{"share", "-", 0.0, 0.005, 0.5}}, g.experiments,
           [member](const Values& v, Changes& c) { (c.*member).load = v[0]; });
}

/// Of motors with a winding and a battery.
void add_electric(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  if (!s.electric) return;

  rows.add("torque_constant", "magnets stronger or weaker than stated", "actuation",
           {{"scale", "-", 1.0, 0.6, 1.4}}, kTail,
           [](const Values& v, Changes& c) { c.torque_constant = v[0]; });
  rows.add(
      "voltage_limit", "the battery is flat", "actuation", {{"shortfall", "-", 0.0, 0.002, 0.6}},
      kTail,
      [bus = s.voltage](const Values& v, Changes& c) { c.voltage_limit = bus * (1.0 - v[0]); });
  rows.add("current_limit", "drivers cut the current early", "actuation",
           {{"shortfall", "-", 0.0, 0.02, 0.8}}, kTail,
           [largest = s.largest_current](const Values& v, Changes& c) {
             c.current_limit = largest * (1.0 - v[0]);
           });

  const double resistance = s.voltage / s.driver_current;
  rows.add("battery_sag", "the battery has an internal resistance", "actuation",
           {strength("resistance", "ohm", 0.001875 * resistance, 0.5625 * resistance)}, kTail,
           [](const Values& v, Changes& c) { c.battery_resistance = v[0]; });
  rows.add("winding_heating", "the windings are warm", "actuation",
           {{"temperature", "K", 0.0, 2.0, 150.0}}, kTail,
           [](const Values& v, Changes& c) { c.winding_rise = v[0]; });
}

}  // namespace

void add_transmission(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  if (s.tail.joints.empty()) return;

  rows.add("tail_compliance", "the tail's shaft bends, in four pieces", "tail_transmission",
           {strength("compliance", "rad/(N m)", 0.006 / s.tail.torque, 0.48 / s.tail.torque),
            {"damping_ratio", "-", 0.05, 0.0, 1.0}},
           kTail, [](const Values& v, Changes& c) {
             if (v[0] == 0.0) return;
             c.shaft_segments = 4;
             c.shaft_stiffness = 1.0 / v[0];
             c.shaft_damping_ratio = v[1];
           });
  rows.add("tail_backlash", "dead band behind the tail's gear", "tail_transmission",
           {{"play", "rad", 0.0, 0.001, 0.06}}, kTail,
           [](const Values& v, Changes& c) { c.tail_play = v[0]; });
  rows.add("tail_stop_restitution", "the tail bounces off its stop", "tail_transmission",
           {{"restitution", "-", 0.0, 0.05, 0.9}}, {Kind::self_righting},
           [](const Values& v, Changes& c) { c.stop_restitution = v[0]; });
}

void add_friction(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  add_friction(rows, {"tail", "tail_transmission", &Changes::tail_friction, s.tail, kTail,
                      1.0 / 6.0, 1.0 / 2400.0, 1.0 / 40000.0, 1.0 / 600.0});
  add_friction(rows, {"leg", "", &Changes::leg_friction, s.legs, kLeap, 1.0 / 5.0, 1.0 / 600.0,
                      1.0 / 10000.0, 1.0 / 150.0});
  if (!s.legs.joints.empty()) return;

  add_friction(rows, {"joint", "actuation", &Changes::leg_friction, s.other, kPendulum, 1.0 / 5.0,
                      1.0 / 600.0, 1.0 / 10000.0, 1.0 / 150.0});
}

void add_actuation(EffectRows& rows) {
  rows.add("actuation_delay", "commands wait in a buffer", "actuation",
           {{"delay", "s", 0.0, 0.0001, 0.006}}, kAll,
           [](const Values& v, Changes& c) { c.delay = v[0]; });
  rows.add("late_start", "the plan starts late", "actuation", {{"time", "s", 0.0, 0.00003, 0.02}},
           kLeap, [](const Values& v, Changes& c) { c.late_start = v[0]; });
  rows.add("controller_gains", "the loop's gains are not those stated", "actuation",
           {{"proportional_scale", "-", 1.0, 0.0, 3.0}, {"derivative_scale", "-", 1.0, 0.0, 3.0}},
           kLeap, [](const Values& v, Changes& c) {
             c.gain_p = v[0];
             c.gain_d = v[1];
           });
  add_electric(rows);
}

void add_sensing(EffectRows& rows) {
  const Sizes& s = rows.sizes;

  if (!s.tail.joints.empty()) {
    rows.add("tail_offset", "the tail's encoder is set wrong", "sensing",
             {{"offset", "rad", 0.0, -0.15, 0.15}}, kLeap,
             [joints = s.tail.joints](const Values& v, Changes& c) {
               for (const std::string& joint : joints) c.joint_offset[joint] += v[0];
             });
  }

  if (!s.legs.joints.empty()) {
    std::vector<BenchParameter> sides;
    if (!s.front.joints.empty()) sides.push_back({"front", "rad", 0.0, -0.1, 0.1});
    if (!s.rear.joints.empty()) sides.push_back({"rear", "rad", 0.0, -0.1, 0.1});
    rows.add("leg_offset", "leg encoders are set wrong", "", sides, kLeap,
             [front = s.front.joints, rear = s.rear.joints](const Values& v, Changes& c) {
               for (const std::string& joint : front) c.joint_offset[joint] += v.front();
               for (const std::string& joint : rear) c.joint_offset[joint] += v.back();
             });
  }

  rows.add("sensor_latency", "sensors stamp late", "sensing",
           {{"latency", "s", 0.0, 0.0001, 0.006}}, kAll, [](const Values& v, Changes& c) {
             c.latency[trajectory::kMocapStream] = c.latency[trajectory::kJointStream] = v[0];
           });
  rows.add("sensor_scale", "motion capture measures lengths wrong", "sensing",
           {{"scale", "-", 1.0, 0.85, 1.15}}, kLeap,
           [](const Values& v, Changes& c) { c.scale["x"] = c.scale["z"] = v[0]; });
  rows.add("tracked_point", "motion capture tracks another point", "sensing",
           {{"x", "m", 0.0, -0.1, 0.1}, {"z", "m", 0.0, -0.05, 0.05}}, kLeap,
           [](const Values& v, Changes& c) { c.tracked_point = Vec2(v[0], v[1]); });
  rows.add("mocap_tilt", "motion capture's axes are tilted", "sensing",
           {{"angle", "rad", 0.0, -0.06, 0.06}}, kLeap,
           [](const Values& v, Changes& c) { c.mocap_tilt = v[0]; });
}

}  // namespace jaculus::testbed
