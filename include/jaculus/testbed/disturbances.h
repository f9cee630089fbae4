#pragma once
// Things outside any catalogue that can be wrong with the robot on the testbed, and pushes. A
// default-built value is a robot on which nothing of this acts. What each does is in
// src/testbed/disturbances.cpp, joint_laws.cpp (laws at a joint), loop.cpp (what the driver makes
// of its commands) and additions.cpp (parts that are built in).

#include <map>
#include <string>

#include "jaculus/core/types.h"

namespace jaculus::testbed {

/// A push that happens once, a half-sine: peak sin(pi (t - start)/length) from start on.
struct Push {
  double peak = 0.0;    ///< signed [N m or N]
  double start = 0.0;   ///< [s]
  double length = 0.1;  ///< [s]
};

/// What acts on legged robots, tails and bases.
struct BodyDisturbances {
  double tether_stiffness = 0.0;  ///< cable behind the robot pulls back once it is taut [N/m]
  double tether_slack = 0.0;      ///< forward motion that the cable allows [m]
  double ripple = 0.0;            ///< torque ripple of every leg motor, 14 waves a turn [N m]
  double dropout = 0.0;           ///< for how long one rear motor goes without torque [s]
  double dropout_start = 0.06;    ///< [s]
  /// the floor holds each rear foot down with up to this force, over 4 mm [N]
  double adhesion = 0.0;
  /// bent cable at the tail's root, a spring that hardens with the cube [N m/rad^3]
  double tail_cable = 0.0;
  double derating = 0.0;         ///< share of its torque that a front left motor loses [-]
  double derating_start = 0.1;   ///< from then on [s]
  double belt_slip = kInfinity;  ///< a rear right motor slips above this torque [N m]
  /// battery that slides in the body along x on a spring of 20 rad/s [kg]
  double loose_mass = 0.0;
  double bent_link = 0.0;   ///< left rear foot's toe reaches further by this [m]
  double push = 0.0;        ///< hand on the base along +x for 20 ms from 0.08 s [N]
  double floor_tilt = 0.0;  ///< of the floor about y, downhill along +x where positive [rad]
  /// of the sway of what the robot stands or is mounted on, along x [m/s^2]
  double shaking = 0.0;
  double shaking_frequency = 4.0;  ///< [Hz]
  double mount_compliance = 0.0;   ///< of a fixed base's mount along x [m/N]
  double sliding_load = 0.0;       ///< part of the last link that slides along it [kg]
};

/// What acts at the joint of every motor. Shares are of what the motor gives at the joint at its
/// limit, of a tail's a twentieth of that. A joint that slides takes a tenth of a metre as a
/// radian.
struct JointDisturbances {
  double hysteresis = 0.0;        ///< [-]
  double hysteresis_width = 0.3;  ///< of motion over which it turns about [rad]
  double tight_spot = 0.0;        ///< dry friction at one angle [-]
  double tight_spot_place = 0.0;  ///< from where the joint starts [rad]
  double grease = 0.0;            ///< friction of grease that is not yet worked loose [-]
  double grease_travel = 0.3;     ///< after which it is down to 1/e [rad]
  double cable = 0.0;             ///< its pull 0.3 rad after it is taut, signed by its side [-]
  double cable_slack = 0.05;      ///< from the start to where it is taut [rad]
  double stop = 0.0;              ///< stiffness of a soft stop, signed by its side [1/rad]
  double stop_place = 0.1;        ///< from where the joint starts [rad]
  double detent = 0.0;            ///< largest torque of a catch [-]
  double detent_place = 0.0;      ///< from where the joint starts [rad]
  double saturation = 0.0;        ///< of magnets: torque lost over torque left, at the limit [-]
  double gear_runout = 0.0;       ///< of the gear's ratio, once a motor turn [-]
  double gear_phase = 0.0;        ///< [rad]
  double square_drag = 0.0;       ///< at 10 rad/s, of joints that are no tail's [-]
  double encoder_runout = 0.0;    ///< once-a-turn error of the reading [rad]
  double encoder_phase = 0.0;     ///< [rad]
};

/// What a driver makes of the commands that it is sent; shares are of its full command.
struct CommandDisturbances {
  double dead_band = 0.0;   ///< on either side of zero [-]
  double step = 0.0;        ///< to whose multiples commands are rounded [-]
  double slew_time = 0.0;   ///< that a command takes from nothing to full [s]
  double lost_time = 0.0;   ///< of every tenth of a second in which packets get lost [s]
  double lost_phase = 0.0;  ///< [s]
};

/// Everything outside any catalogue.
struct Disturbances : BodyDisturbances {
  JointDisturbances joints;
  CommandDisturbances commands;
  /// of a planar joint, at each of its motors' joints
  std::map<std::string, Push> joint_push;
  Push base_push;  ///< along +x at the base's centre of mass
};

}  // namespace jaculus::testbed
