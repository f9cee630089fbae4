#include "testbed/joint_changes.h"

#include <array>
#include <cmath>

#include "testbed/loop.h"

namespace jaculus::testbed {
namespace {

/// Friction of the joint's group, and of the joint alone.
std::array<DryFriction, 2> frictions_of(const Changes& changes, const Drive& drive) {
  const auto own = changes.joint_friction.find(drive.planar);
  return {drive.limb == Limb::tail ? changes.tail_friction : changes.leg_friction,
          own == changes.joint_friction.end() ? DryFriction{} : own->second};
}

}  // namespace

double play_of(const Changes& changes, const Drive& drive) {
  const double group = drive.limb == Limb::tail ? changes.tail_play : changes.leg_play;
  return group + value_of(changes.joint_play, drive.planar, 0.0);
}

double added_rotor_inertia(const Changes& changes, const Drive& drive) {
  const bool tail = drive.limb == Limb::tail;
  return (tail ? changes.tail_rotor_inertia : changes.leg_rotor_inertia) +
         value_of(changes.joint_rotor_inertia, drive.planar, 0.0);
}

double viscous_friction(const Changes& changes, const Drive& drive) {
  double sum = drive.motor.viscous_friction;
  for (const DryFriction& f : frictions_of(changes, drive)) sum += f.viscous;
  return sum;
}

double torque_offset(const Changes& changes, const Drive& drive) {
  const bool tail = drive.limb == Limb::tail;
  return (tail ? changes.tail_torque_offset : changes.leg_torque_offset) +
         value_of(changes.joint_torque_offset, drive.planar, 0.0);
}

bool rubs(const Changes& changes, const Drive& drive) {
  double sum = drive.friction + drive.motor.dry_friction;
  for (const DryFriction& f : frictions_of(changes, drive))
    sum += f.coulomb + f.stribeck + f.load + f.positive + f.negative;
  return sum > 0.0;
}

double dry_friction(const Changes& changes, const Drive& drive, double rate, double torque) {
  double level = drive.friction + drive.motor.dry_friction;
  for (const DryFriction& f : frictions_of(changes, drive)) {
    const double ratio = rate / f.stribeck_rate;
    level += f.coulomb + f.stribeck * std::exp(-ratio * ratio) + f.load * torque;
    level += rate == 0.0 ? 0.5 * (f.positive + f.negative) : rate > 0.0 ? f.positive : f.negative;
  }
  return level;
}

}  // namespace jaculus::testbed
