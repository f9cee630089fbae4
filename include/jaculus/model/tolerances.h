#pragma once
// How far a robot may be from its files without anything being wrong with it: what a careful
// builder can't know. robot.yaml states it under `tolerances`; without it the defaults below hold.
//
// Each is the standard deviation of what the value is off by, independently for every link, joint
// and motor; nothing within tolerance is off by more than two of them. Defaults: weighed parts and
// a balanced centre of mass (3 %, 2 mm), machined lengths (0.3 %), motors of one batch (k_t and R
// 4 %, what makers state as +-10 %), encoders zeroed by hand (3 mrad), gains of a driver's scaling
// (3 %), a floor whose friction was measured once (10 %), bearings and gears that rub with 0.5 %
// of the motor's largest torque, drivers whose ammeters are 2 % off and pass 80 Hz or more (1 ms).

#include <string_view>
#include <vector>

#include "jaculus/core/units.h"
#include "jaculus/core/yaml.h"

namespace jaculus::model {

struct Tolerances {
  double mass = 0.03;             ///< of each link, share of it [-]
  double inertia = 0.03;          ///< of each link about its centre of mass, share of it [-]
  double com = 2e-3;              ///< of each link, along either axis of the plane [m]
  double length = 3e-3;           ///< from a joint to the next or to a foot, share of it [-]
  double torque_constant = 0.04;  ///< of each motor, share of it [-]
  double resistance = 0.04;       ///< of each motor, share of it [-]
  double joint_friction = 5e-3;   ///< dry, share of the largest torque at the joint [-]
  double encoder_zero = 3e-3;     ///< of each joint [rad]; of a sliding one this in metres
  double gain = 0.03;             ///< of each feedback gain, share of it [-]
  double floor_friction = 0.1;    ///< share of the stated coefficient [-]
  double current_scale = 0.02;    ///< of logged current or torque, share of it [-]
  double current_filter = 1e-3;   ///< low pass of logged current or torque, time constant [s]
};

/// A key of `tolerances`, declared once: read, explained and listed by it.
struct ToleranceKey {
  std::string_view name;
  double Tolerances::*member;
  Dimension dimension;
  std::string_view meaning;
};
const std::vector<ToleranceKey>& tolerance_keys();

/// Reads the section `tolerances` of robot.yaml. Absent keys keep their defaults. InputError for
/// an unknown key, a negative value, or a share above 0.5.
Tolerances read_tolerances(const yaml::Node& robot);

}  // namespace jaculus::model
