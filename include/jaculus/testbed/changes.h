#pragma once
// What can be physically different about the robot on the testbed. Every field is a change of the
// MuJoCo robot, its drives, its floor or its sensors, made here and nowhere else; a default-built
// value is the robot that its files describe.
//
// The testbed stands in for hardware: nothing here is shared with the plant, and no name here is
// known to the diagnosis.

#include <map>
#include <string>

#include "jaculus/core/types.h"
#include "jaculus/testbed/disturbances.h"

namespace jaculus::testbed {

/// Friction in a joint, as MuJoCo's dry friction (a constraint that can stick) whose level is
/// renewed every step:
///   loss = coulomb + stribeck exp(-(w/stribeck_rate)^2) + load |motor torque at the joint|
///          + positive or negative, by the sign of w (the mean of both at rest),
///     and viscous damping beside it.
struct DryFriction {
  double coulomb = 0.0;        ///< [N m]
  double viscous = 0.0;        ///< [N m s/rad]
  double stribeck = 0.0;       ///< [N m]
  double stribeck_rate = 2.0;  ///< [rad/s]
  double load = 0.0;           ///< [-]
  double positive = 0.0;       ///< beside coulomb while the joint's angle grows [N m]
  double negative = 0.0;       ///< while it falls [N m]
};

struct Changes {
  // Tail's shaft and gears
  int shaft_segments = 0;  ///< joints along the flexible part of the shaft; 0: rigid
  /// force at the scoop's middle times its distance over the angle it yields [N m/rad]
  double shaft_stiffness = 0.0;
  double shaft_damping_ratio = 0.05;  ///< of the first bending of the shaft [-]
  double tail_play = 0.0;             ///< dead band behind the tail's motor, whole width [rad]
  double leg_play = 0.0;              ///< of every other motor [rad]
  /// planar joint: added dead band behind its motor, whole width [rad]
  std::map<std::string, double> joint_play;
  // Joints
  DryFriction tail_friction;
  DryFriction leg_friction;  ///< of every motor's joint that is not the tail's
  /// planar joint: friction beside that of its group
  std::map<std::string, DryFriction> joint_friction;
  double tail_rotor_inertia = 0.0;  ///< added, before the gear [kg m^2]
  double leg_rotor_inertia = 0.0;   ///< added to every other, before the gear [kg m^2]
  /// planar joint: added to its motor's alone, before the gear [kg m^2]
  std::map<std::string, double> joint_rotor_inertia;
  /// planar joint: encoder reads the angle plus this [rad]
  std::map<std::string, double> joint_offset;
  double stop_restitution = 0.0;  ///< of the tail's stop [-]
  /// beside the motor's torque and in no log, positive as the joint's angle [N m]
  double tail_torque_offset = 0.0;
  double leg_torque_offset = 0.0;  ///< at every motor's joint that is not the tail's [N m]
  /// planar joint: beside that of its group [N m]
  std::map<std::string, double> joint_torque_offset;
  // Drives
  double delay = 0.0;                 ///< from sample to torque [s]
  double late_start = 0.0;            ///< from the logs' zero to the plan's [s]
  double battery_resistance = 0.0;    ///< [ohm]
  double winding_rise = 0.0;          ///< of every winding at the start [K]
  double winding_heat = 0.0;          ///< [K/J]
  double torque_constant = 1.0;       ///< factor on torque a current and on back-EMF [-]
  double voltage_limit = kInfinity;   ///< battery lower than believed [V]
  double current_limit = kInfinity;   ///< driver limits earlier than believed [A]
  double gain_p = 1.0, gain_d = 1.0;  ///< factors on the loop's gains [-]
  /// planar joint: factor on that of its motor alone [-]
  std::map<std::string, double> joint_torque_constant;
  // Air
  double drag_coefficient = 1.0;          ///< factor [-]
  bool drag_ignores_translation = false;  ///< a couple by the tail's rotation alone (equation 2)
  double wind = 0.0;                      ///< along +x [m/s]
  // Floor and feet
  double floor_friction_scale = 1.0;   ///< factor on the believed friction [-]
  double floor_stiffness = kInfinity;  ///< under one foot [N/m]
  double floor_damping_ratio = 0.3;    ///< of a quarter of the robot on it [-]
  double toe_radius = 0.0;             ///< [m]
  // Masses
  double payload = 0.0;                  ///< [kg]
  Vec2 payload_place = Vec2(0.1, 0.05);  ///< in the base's frame [m]
  Vec2 com_shift = Vec2::Zero();         ///< of the base [m]
  double base_inertia = 1.0;             ///< factor on the base's pitch inertia [-]
  double tail_mass = 1.0;     ///< factor on mass and inertia of the tail's moving parts [-]
  double tail_inertia = 1.0;  ///< factor on the tail's inertia about its centre of mass alone [-]
  /// factor on the inertia of all leg links about their centres of mass [-]
  double leg_inertia = 1.0;
  /// of a fixed base about y, downhill along +x where positive [rad]
  double base_tilt = 0.0;
  // Sensors
  std::map<std::string, double> latency;  ///< by stream [s]
  std::map<std::string, double> scale;    ///< by channel [-]
  Vec2 tracked_point = Vec2::Zero();      ///< by motion capture, in the base's frame [m]
  double mocap_tilt = 0.0;                ///< of its axes about +y [rad]
  Disturbances outside;
};

}  // namespace jaculus::testbed
