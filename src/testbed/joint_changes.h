#pragma once
// What changes make of one motor's joint: those of its group (tail, or every other joint) and those
// of this joint alone.

#include "jaculus/testbed/changes.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// Dead band behind the motor, whole width [rad].
double play_of(const Changes& changes, const Drive& drive);
/// Rotor inertia beside the stated one, before the gear [kg m^2].
double added_rotor_inertia(const Changes& changes, const Drive& drive);
/// Damping [N m s/rad].
double viscous_friction(const Changes& changes, const Drive& drive);
/// Torque beside the motor's [N m].
double torque_offset(const Changes& changes, const Drive& drive);
/// Whether there is dry friction of a healthy bearing or of changes.
bool rubs(const Changes& changes, const Drive& drive);
/// Its level [N m] at a joint rate [rad/s] and under a motor torque of this size [N m].
double dry_friction(const Changes& changes, const Drive& drive, double rate, double torque);

}  // namespace jaculus::testbed
