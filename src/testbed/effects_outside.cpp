// The testbed's effects that no catalogue holds; what they do is in disturbances.cpp.

#include "testbed/effect_rows.h"

namespace jaculus::testbed {
namespace {

/// What pulls or pushes the base.
void add_tether(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  if (!rows.files.floating) return;
  rows.add_outside(
      "tether", "a cable behind the robot pulls once it is taut",
      {strength("stiffness", "N/m", 0.028 * s.weight / s.length, 11.2 * s.weight / s.length),
       {"slack", "m", round_figure(0.059 * s.length), 0.0, round_figure(0.294 * s.length)}},
      kLeap, [](const Values& v, Changes& c) {
        c.outside.tether_stiffness = v[0];
        c.outside.tether_slack = v[1];
      });
}

void add_leg_motors(EffectRows& rows) {
  const double torque = rows.sizes.legs.torque;
  if (rows.sizes.legs.joints.empty()) return;
  rows.add_outside("torque_ripple", "leg motors cog",
                   {strength("amplitude", "N m", torque / 1000.0, torque / 6.0)}, kLeap,
                   [](const Values& v, Changes& c) { c.outside.ripple = v[0]; });
  rows.add_outside("command_dropout", "one rear motor goes without torque for a while",
                   {{"duration", "s", 0.0, 0.002, 0.08}, {"start", "s", 0.06, 0.0, 0.15}}, kLeap,
                   [](const Values& v, Changes& c) {
                     c.outside.dropout = v[0];
                     c.outside.dropout_start = v[1];
                   });
}

void add_failing_motors(EffectRows& rows) {
  const double torque = rows.sizes.legs.torque;
  if (rows.sizes.legs.joints.empty()) return;
  rows.add_outside("thermal_derating",
                   "a front motor of one side loses a share of its torque mid-leap",
                   {{"share", "-", 0.0, 0.01, 1.0}, {"start", "s", 0.1, 0.0, 0.2}}, kLeap,
                   [](const Values& v, Changes& c) {
                     c.outside.derating = v[0];
                     c.outside.derating_start = v[1];
                   });

  const double grip = round_figure(torque * 11.0 / 15.0);  // of a belt as it should be
  rows.add_outside("slipping_belt", "a rear motor of one side slips above a torque",
                   {strength("shortfall", "N m", torque / 60.0, torque * 2.0 / 3.0)}, kLeap,
                   [grip](const Values& v, Changes& c) {
                     c.outside.belt_slip = v[0] > 0.0 ? grip - v[0] : kInfinity;
                   });
}

}  // namespace

void add_outside(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  const bool feet = !rows.files.toes.empty();

  add_tether(rows);
  add_leg_motors(rows);
  if (feet) {
    rows.add_outside("sticky_floor", "the floor holds the rear feet down",
                     {strength("force", "N", 0.033 * s.weight, 3.3 * s.weight)}, kLeap,
                     [](const Values& v, Changes& c) { c.outside.adhesion = v[0]; });
  }

  if (!s.tail.joints.empty()) {
    rows.add_outside(
        "tail_cable", "a bent cable at the tail's root, a spring that hardens",
        {strength("stiffness", "N m/rad^3", s.tail.torque / 240.0, s.tail.torque / 2.0)}, kTail,
        [](const Values& v, Changes& c) { c.outside.tail_cable = v[0]; });
  }

  add_failing_motors(rows);
  if (rows.files.floating) {
    rows.add_outside("loose_battery", "the battery slides in the body",
                     {strength("mass", "kg", 0.008 * s.mass, 0.404 * s.mass)}, kLeap,
                     [](const Values& v, Changes& c) { c.outside.loose_mass = v[0]; });
  }
  if (feet) {
    rows.add_outside("tilted_floor", "the floor is not level", {{"angle", "rad", 0.0, -0.1, 0.1}},
                     kLeap, [](const Values& v, Changes& c) { c.outside.floor_tilt = v[0]; });
    rows.add_outside("bent_leg", "one rear toe reaches further than the other",
                     {strength("length", "m", 0.00147 * s.length, 0.059 * s.length)}, kLeap,
                     [](const Values& v, Changes& c) { c.outside.bent_link = v[0]; });
  }
  if (rows.files.floating) {
    rows.add_outside("push", "a hand pushes the body once",
                     {strength("force", "N", 0.033 * s.weight, 2.47 * s.weight)}, kMoving,
                     [](const Values& v, Changes& c) { c.outside.push = v[0]; });
  }
}

}  // namespace jaculus::testbed
