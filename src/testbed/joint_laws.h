#pragma once
// Laws of what is wrong at one motor's joint and no catalogue holds. u is the angle from where the
// joint starts, in radians (a slide's in tenths of a metre), T the motor's torque at the joint at
// its limit, of a tail a twentieth of that, for its motor is sized by the fling; every a is a share
// of T.
//
//   hysteresis   torque -a T z,  dz/du = (1 - z sign(u'))/w: elastic before it slides, and back by
//                another way (Dahl 1968); solved exactly along a motion one way,
//                z(u) = s + (z0 - s) exp(-|u - u0|/w), s = sign(u - u0)
//   tight spot   dry friction a T exp(-x^2/2), x = (u - place)/0.1
//   grease       dry friction a T exp(-s/travel), s the way travelled: a structure that shearing
//                breaks down and that does not build up again within a trial (Moore 1959)
//   cable        torque a T (p/0.3)^2 back, p the angle beyond where it is taut, on one side; from
//                p = 0.3 on it slips through its clamp
//   stop         torque a T p (1 + 0.5 p') back, never forward (Hunt and Crossley 1975); p goes no
//                further than 0.1, where it yields
//   catch        torque -a T x exp((1 - x^2)/2), x = (u - place)/0.1: a well whose steepest place
//                takes a T, as of two magnets that pass
//   magnets      torque t arrives as t/(1 + a (t/limit)^2): iron saturates, and the driver works
//   its
//                torque out of the current
//   gear         torque t arrives as t (1 + a sin(gear q + phase)): a wheel that runs out of true
//   square drag  torque -a T |u'| u'/100, that of a paddle in air or grease that churns
//   encoder      reads q + e (sin(q + phase) - sin(phase)): its disc is off the axis; set right at
//   0

#include "jaculus/testbed/disturbances.h"
#include "testbed/sizes.h"

namespace jaculus::testbed {

/// What a joint remembers.
struct JointMemory {
  double start = 0.0;    ///< where it started [rad or m]
  double last = 0.0;     ///< u at the end of the step before [rad]
  double bristle = 0.0;  ///< z then [-]
  double travel = 0.0;   ///< way until then [rad]
};

/// A joint as a law sees it.
struct JointMotion {
  double angle = 0.0;   ///< [rad or m]
  double rate = 0.0;    ///< [rad/s or m/s]
  double torque = 0.0;  ///< that the motor gives at the joint [N m or N]
};

/// What the laws add to the motor's torque [N m or N]; dry friction is none of it.
double torque_of_laws(const JointDisturbances& o, const JointSize& size, const Drive& drive,
                      const JointMemory& memory, const JointMotion& now);
/// Dry friction that they add [N m or N].
double friction_of_laws(const JointDisturbances& o, const JointSize& size, const Drive& drive,
                        const JointMemory& memory);
/// What the joint remembers after a motion one way to `angle`.
JointMemory moved(const JointDisturbances& o, const JointSize& size, JointMemory memory,
                  double angle);

/// What an encoder reads too much [rad or m], and its share of the rate [-].
double misreading(const JointDisturbances& o, const JointSize& size, double angle);
double misreading_rate(const JointDisturbances& o, const JointSize& size, double angle);

}  // namespace jaculus::testbed
