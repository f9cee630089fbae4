#pragma once
// Quantities of joints, coordinates and feet, and the names of the columns and channels that hold
// them: "front_a" is a position, "front_a_velocity" a rate, "front_foot_force_z" a force.

#include <string>
#include <string_view>
#include <vector>

#include "jaculus/core/names.h"
#include "jaculus/core/units.h"

namespace jaculus::trajectory {

/// A command is a torque, a duty or a voltage; a log may hold any of these.
enum class Quantity {
  position,      ///< no suffix [rad or m]
  velocity,      ///< [rad/s or m/s]
  acceleration,  ///< [rad/s^2 or m/s^2]
  torque,        ///< at the joint, behind the gear [N m or N]
  motor_torque,  ///< before the gear [N m or N]
  current,       ///< of one motor [A]
  voltage,       ///< [V]
  duty,          ///< share of the bus voltage [-]
  force,         ///< [N]
  force_x,       ///< [N]
  force_z,       ///< [N]
  apart          ///< of two sides that are one joint: the first less the second [rad or m]
};

/// "torque", "force_x"; the suffix of a column is "_" and this.
const NameTable<Quantity>& quantity_names();
const char* name_of(Quantity quantity);

/// Dimensions that a quantity may have, that of revolute joints first.
const std::vector<Dimension>& dimensions_of(Quantity quantity);
/// SI unit of a quantity of what turns ("rad/s") or slides ("m/s").
std::string unit_of(Quantity quantity, bool slides = false);

/// What a command may be: torque, duty, voltage.
const NameTable<Quantity>& command_names();

/// A column's name in its parts.
struct ChannelName {
  std::string of;  ///< joint, coordinate or foot: "front_a"
  Quantity quantity = Quantity::position;
};

/// Takes a name apart. One without a known suffix is a position: {"imu_pitch", position}.
ChannelName parse_channel(std::string_view name);

/// "front_a" and velocity: "front_a_velocity".
std::string channel_name(std::string_view of, Quantity quantity);

}  // namespace jaculus::trajectory
