// The testbed's effects that no catalogue holds and that any robot with a motor can have, and
// pushes. Laws at a joint are in joint_laws.h, those of a driver in loop.cpp.

#include <cmath>
#include <numbers>

#include "testbed/additions.h"
#include "testbed/effect_rows.h"

namespace jaculus::testbed {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;  ///< [rad]

/// What rubs.
void add_rubbing(EffectRows& rows) {
  rows.add_outside("hysteresis", "cables bundled across the joints bend back by another way",
                   {{"share", "-", 0.0, 0.0005, 0.5}, drawn("width", "rad", 0.3, 0.1, 0.6)}, kAll,
                   [](const Values& v, Changes& c) {
                     c.outside.joints.hysteresis = v[0];
                     c.outside.joints.hysteresis_width = v[1];
                   });
  rows.add_outside("tight_spot", "the joints rub at one angle",
                   {{"share", "-", 0.0, 0.0005, 0.8}, drawn("place", "rad", 0.15, -0.4, 0.4)}, kAll,
                   [](const Values& v, Changes& c) {
                     c.outside.joints.tight_spot = v[0];
                     c.outside.joints.tight_spot_place = v[1];
                   });
  rows.add_outside("stiff_grease", "grease that has set is worked loose",
                   {{"share", "-", 0.0, 0.0005, 0.5}, drawn("travel", "rad", 0.3, 0.1, 0.8)}, kAll,
                   [](const Values& v, Changes& c) {
                     c.outside.joints.grease = v[0];
                     c.outside.joints.grease_travel = v[1];
                   });

  // On tails this is what the air does.
  const bool legs = !rows.sizes.legs.joints.empty();
  if (!legs && rows.sizes.other.joints.empty()) return;
  const double most = legs ? 1.0 : 8.0;  // a pendulum is slower than a leg
  rows.add_outside("square_drag", "drag that grows with the square of speed",
                   {{"share", "-", 0.0, 0.0005 * most, most}}, {kLeap.front(), kPendulum.front()},
                   [](const Values& v, Changes& c) { c.outside.joints.square_drag = v[0]; });
}

/// What pulls or pushes at some angles; either side.
void add_springs(EffectRows& rows) {
  rows.add_outside("joint_cable", "a cable across the joints gets taut",
                   {{"share", "-", 0.0, -2.0, 2.0}, drawn("slack", "rad", 0.05, 0.0, 0.1)}, kAll,
                   [](const Values& v, Changes& c) {
                     c.outside.joints.cable = v[0];
                     c.outside.joints.cable_slack = v[1];
                   });
  rows.add_outside(
      "early_stop", "the joints meet something soft before their stop",
      {{"stiffness", "1/rad", 0.0, -20.0, 20.0}, drawn("place", "rad", 0.1, 0.02, 0.2)}, kAll,
      [](const Values& v, Changes& c) {
        c.outside.joints.stop = v[0];
        c.outside.joints.stop_place = v[1];
      });
  rows.add_outside("catch", "magnets catch the joints at one angle",
                   {{"share", "-", 0.0, 0.001, 1.0}, drawn("place", "rad", 0.1, -0.3, 0.3)}, kAll,
                   [](const Values& v, Changes& c) {
                     c.outside.joints.detent = v[0];
                     c.outside.joints.detent_place = v[1];
                   });
}

/// What makes less or other of a motor's torque or an encoder's angle.
void add_machinery(EffectRows& rows) {
  rows.add_outside("magnet_saturation", "iron of the motors saturates",
                   {{"share", "-", 0.0, 0.001, 1.5}}, kAll,
                   [](const Values& v, Changes& c) { c.outside.joints.saturation = v[0]; });
  rows.add_outside("gear_runout", "a gear wheel runs out of true",
                   {{"share", "-", 0.0, 0.001, 0.5}, drawn("phase", "rad", 0.0, 0.0, kTurn)}, kAll,
                   [](const Values& v, Changes& c) {
                     c.outside.joints.gear_runout = v[0];
                     c.outside.joints.gear_phase = v[1];
                   });
  rows.add_outside("encoder_runout", "the encoders' discs are off their axes",
                   {{"error", "rad", 0.0, 0.0003, 0.1}, drawn("phase", "rad", 0.0, 0.0, kTurn)},
                   kAll, [](const Values& v, Changes& c) {
                     c.outside.joints.encoder_runout = v[0];
                     c.outside.joints.encoder_phase = v[1];
                   });
}

void add_drivers(EffectRows& rows) {
  rows.add_outside("driver_dead_band", "drivers give nothing for small commands",
                   {{"share", "-", 0.0, 0.0003, 0.3}}, kAll,
                   [](const Values& v, Changes& c) { c.outside.commands.dead_band = v[0]; });
  rows.add_outside("coarse_commands", "drivers round their commands",
                   {{"step", "-", 0.0, 0.0005, 0.5}}, kAll,
                   [](const Values& v, Changes& c) { c.outside.commands.step = v[0]; });
  rows.add_outside("command_slew", "firmware limits how fast a command may change",
                   {{"time", "s", 0.0, 0.0005, 0.3}}, kAll,
                   [](const Values& v, Changes& c) { c.outside.commands.slew_time = v[0]; });
  rows.add_outside("lost_packets", "commands get lost in bursts, the last one goes on",
                   {{"time", "s", 0.0, 0.001, 0.09}, drawn("phase", "s", 0.0, 0.0, 0.1)}, kAll,
                   [](const Values& v, Changes& c) {
                     c.outside.commands.lost_time = v[0];
                     c.outside.commands.lost_phase = v[1];
                   });
}

/// What the robot stands on or is mounted on, what its last link carries.
void add_support(EffectRows& rows) {
  rows.add_outside(
      "shaking_support", "the floor or bench sways",
      {{"acceleration", "m/s^2", 0.0, 0.005, 5.0}, drawn("frequency", "Hz", 4.0, 2.0, 8.0)},
      kSupported, [](const Values& v, Changes& c) {
        c.outside.shaking = v[0];
        c.outside.shaking_frequency = v[1];
      });

  // From 60 Hz down to 2 Hz with the robot on it.
  const double mass = mass_of(rows.files) + mount_mass(rows.files);
  const auto compliance_at = [&](double hertz) {
    return 1.0 / (mass * std::pow(kTurn * hertz, 2));
  };
  rows.add_outside("compliant_mount", "the mount of a fixed base sways",
                   {strength("compliance", "m/N", compliance_at(60.0), compliance_at(2.0))}, kHeld,
                   [](const Values& v, Changes& c) { c.outside.mount_compliance = v[0]; });

  const int last = loaded_link(rows.files);
  if (last < 0 || rows.files.floating) return;
  const double link = rows.files.tree.links[last].mass;
  rows.add_outside("sliding_load", "part of the last link slides along it",
                   {strength("mass", "kg", 0.001 * link, 0.8 * link)}, kPendulum,
                   [](const Values& v, Changes& c) { c.outside.sliding_load = v[0]; });
}

/// Peak, start and length of a push. Starts are within the first 0.3 s of a leap or drop, the first
/// 10 s of anything else; a case draws it within its experiment.
std::vector<BenchParameter> push_parameters(const std::string& unit, double peak, double latest) {
  const double most = round_figure(peak);
  return {{"peak", unit, 0.0, -most, most},
          drawn("start", "s", 0.05, 0.0, latest),
          drawn("length", "s", 0.1, 0.05, 0.5)};
}

const Experiments& experiments_of(Limb limb) {
  if (limb == Limb::tail) return kTail;
  return limb == Limb::other ? kPendulum : kLeap;
}

}  // namespace

void add_outside_anywhere(EffectRows& rows) {
  if (rows.files.drives.empty()) return;
  add_rubbing(rows);
  add_springs(rows);
  add_machinery(rows);
  add_drivers(rows);
  add_support(rows);
}

void add_pushes(EffectRows& rows) {
  const double latest = rows.files.floating ? 0.3 : 10.0;

  for (const std::string& joint : rows.files.planar_motors) {
    const Drive& drive = rows.files.drives[rows.files.sides_of(joint).front()];
    const JointSize size = size_of(rows.files, drive);
    const std::string unit = size.radian == 1.0 ? "N m" : "N";
    BenchEffect& push =
        rows.add_outside("joint_push@" + joint, "something pushes once at " + joint,
                         push_parameters(unit, size.torque, latest), experiments_of(drive.limb),
                         [joint](const Values& v, Changes& c) {
                           c.outside.joint_push[joint] = {v[0], v[1], v[2]};
                         });
    push.event = true;
    push.joint = joint;
  }

  if (!rows.files.floating) return;
  rows.add_outside("base_push", "something pushes the body once along x",
                   push_parameters("N", 1.5 * rows.sizes.weight, latest), kMoving,
                   [](const Values& v, Changes& c) {
                     c.outside.base_push = {v[0], v[1], v[2]};
                   })
      .event = true;
}

}  // namespace jaculus::testbed
