#pragma once
// What a robot is like, to which the strengths of effects are relative, and round figures of it.

#include <string>
#include <vector>

#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// What motors of one kind can do.
struct MotorSizes {
  std::vector<std::string> joints;  ///< planar; empty: there are none
  double torque = 0.0;              ///< one motor's limit, at the joint [N m]
  double motor_torque = 0.0;        ///< before the gear [N m]
};

struct Sizes {
  MotorSizes tail, legs, front, rear, other;
  bool electric = false;         ///< whether every motor is
  double voltage = 0.0;          ///< lowest of the motors' bus [V]
  double driver_current = 0.0;   ///< lowest of the drivers' limits [A]
  double largest_current = 0.0;  ///< that a motor takes at its torque limit, lowest of all [A]
  double mass = 0.0;             ///< of the base's link [kg]
  double length = 0.0;  ///< of a leg from where it leaves the base to the toe, or reach [m]
  double weight = 0.0;  ///< of the base's link [N]
  double speed = 0.0;   ///< sqrt(gravity length) [m/s]
};

Sizes sizes_of(const RobotFiles& files);

/// What the joint of one motor is measured by.
struct JointSize {
  double torque = 0.0;        ///< the motor's limit at the joint [N m or N]
  double motor_torque = 0.0;  ///< before the gear [N m or N]
  double radian = 1.0;        ///< what counts as a radian: of a joint that slides 0.1 m [rad or m]
};
JointSize size_of(const RobotFiles& files, const Drive& drive);

/// Of all links [kg].
double mass_of(const RobotFiles& files);

/// The nearest number of two significant digits.
double round_figure(double value);

}  // namespace jaculus::testbed
