// The testbed's effects of air, masses and floor.

#include "testbed/effect_rows.h"

namespace jaculus::testbed {
namespace {

void add_link_masses(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  if (!s.tail.joints.empty()) {
    rows.add("tail_link_mass", "a heavier tail", "tail_transmission",
             {{"scale", "-", 1.0, 0.4, 2.0}}, kTail,
             [](const Values& v, Changes& c) { c.tail_mass = v[0]; });
    rows.add("tail_link_inertia", "tail spread wider about its centre of mass", "tail_transmission",
             {{"scale", "-", 1.0, 0.3, 3.0}}, kTail,
             [](const Values& v, Changes& c) { c.tail_inertia = v[0]; });
  }
  if (s.legs.joints.empty()) return;

  rows.add("leg_link_inertia", "leg links with other inertias", "", {{"scale", "-", 1.0, 0.3, 5.0}},
           kLeap, [](const Values& v, Changes& c) { c.leg_inertia = v[0]; });
}

void add_base_masses(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  if (!rows.files.floating) return;

  const auto place = [&](const std::string& name, double usual, double lower, double upper) {
    return BenchParameter{name,
                          "m",
                          round_figure(usual * s.length),
                          round_figure(lower * s.length),
                          round_figure(upper * s.length),
                          true};
  };

  rows.add("payload", "a mass on the body", "body",
           {strength("mass", "kg", 0.00081 * s.mass, 0.323 * s.mass),
            place("x", 0.294, -0.735, 0.735), place("z", 0.147, -0.147, 0.441)},
           kMoving, [](const Values& v, Changes& c) {
             c.payload = v[0];
             c.payload_place = {v[1], v[2]};
           });
  rows.add("com_shift", "the body's masses are elsewhere", "body",
           {strength("x", "m", -0.176 * s.length, 0.176 * s.length),
            strength("z", "m", -0.147 * s.length, 0.147 * s.length)},
           kMoving, [](const Values& v, Changes& c) {
             c.com_shift = {v[0], v[1]};
           });
  rows.add("body_inertia", "the body's masses are spread otherwise", "body",
           {{"scale", "-", 1.0, 0.5, 2.0}}, kMoving,
           [](const Values& v, Changes& c) { c.base_inertia = v[0]; });
}

}  // namespace

void add_air(EffectRows& rows) {
  if (rows.files.drags.empty()) return;
  rows.add("drag_coefficient", "the scoop drags more or less", "tail_aerodynamics",
           {{"scale", "-", 1.0, 0.0, 3.0}}, kTail,
           [](const Values& v, Changes& c) { c.drag_coefficient = v[0]; });
  rows.add("drag_without_translation", "drag as a couple by the tail's rotation alone",
           "tail_aerodynamics", {{"share", "-", 0.0, 1.0, 1.0}}, kMoving,
           [](const Values& v, Changes& c) { c.drag_ignores_translation = v[0] > 0.0; });

  const double speed = 2.19 * rows.sizes.speed;
  rows.add("wind", "a fan", "tail_aerodynamics", {strength("speed", "m/s", -speed, speed)}, kTail,
           [](const Values& v, Changes& c) { c.wind = v[0]; });
}

void add_masses(EffectRows& rows) {
  const Sizes& s = rows.sizes;

  // Rotors that the motor's torque takes a while to turn up: torque over an acceleration [rad/s^2].
  if (!s.tail.joints.empty()) {
    rows.add("tail_rotor_inertia", "a heavier rotor", "tail_transmission",
             {strength("inertia", "kg m^2", s.tail.motor_torque / 3e6, s.tail.motor_torque / 1e4)},
             kTail, [](const Values& v, Changes& c) { c.tail_rotor_inertia = v[0]; });
  }
  if (!s.legs.joints.empty()) {
    rows.add(
        "leg_rotor_inertia", "heavier rotors", "",
        {strength("inertia", "kg m^2", s.legs.motor_torque / 1.5e6, s.legs.motor_torque / 7.5e3)},
        kLeap, [](const Values& v, Changes& c) { c.leg_rotor_inertia = v[0]; });
  }

  add_link_masses(rows);
  add_base_masses(rows);
}

void add_contact(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  if (rows.files.toes.empty()) return;

  rows.add("foot_friction", "a slippery floor", "contact", {{"scale", "-", 1.0, 0.25, 0.6}}, kLeap,
           [](const Values& v, Changes& c) { c.floor_friction_scale = v[0]; });
  const double yielding = s.length / s.weight;  // the floor sinks by a leg under the body's weight
  rows.add("ground_compliance", "floor plates on springs", "contact",
           {strength("compliance", "m/N", 0.000536 * yielding, 0.0536 * yielding),
            {"damping_ratio", "-", 0.3, 0.0, 2.0}},
           kLeap, [](const Values& v, Changes& c) {
             if (v[0] == 0.0) return;
             c.floor_stiffness = 1.0 / v[0];
             c.floor_damping_ratio = v[1];
           });
  rows.add("foot_radius", "round toes", "contact",
           {strength("radius", "m", 0.00147 * s.length, 0.059 * s.length)}, kLeap,
           [](const Values& v, Changes& c) { c.toe_radius = v[0]; });
}

}  // namespace jaculus::testbed
