#pragma once
// A reorientation as a user describes it, and every number in it by name, so that grids and
// searches can turn any of them.
//
// Names are "group.key" as in a study's `base`: body.inertia, tail.length, motor.gear, task.drop,
// ... Alternatives exclude one another: tail.inertia or tail.normalised_inertia = I_t/(I_b + I_t);
// tail.shaft or tail.shaft_ratio = L0/L; task.drop (the duration is then that of the fall) or
// task.duration. Setting one of a pair unsets the other.
//
// Scaling (section VI-D of Norby et al. 2021) by a factor s at constant gravity and density:
// lengths and the drop grow by s, inertias by s^5. scaling.tail: isometric; fixed_width (the tail's
// width stays, its normalised inertia too); fixed_tail (nothing of the tail changes).
// scaling.motor: fixed, or similar: gear by s^(1/2) and s^3.5 such motors side by side, so that
// joint torque grows by s^4 and rates by s^(-1/2), which makes an isometric fall the same motion in
// slower time.

#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/studies/reorientation.h"

namespace jaculus::studies {

inline constexpr Bounds kPositive{1e-12, 1e12};
inline constexpr Bounds kNotNegative{0.0, 1e12};

enum class TailScaling { isometric, fixed_width, fixed_tail };
enum class MotorScaling { fixed, similar };

/// NaN: not given.
struct ReorientationSetup {
  double body_inertia = kNaN;        ///< about the tail's pin [kg m^2]
  double tail_inertia = kNaN;        ///< about the pin [kg m^2]
  double normalised_inertia = kNaN;  ///< I_t/(I_b + I_t), in place of tail_inertia [-]
  double tail_length = kNaN;         ///< L [m]
  double tail_shaft = kNaN;          ///< L0 [m]
  double shaft_ratio = kNaN;         ///< L0/L, in place of tail_shaft [-]
  double tail_width = kNaN;          ///< w [m]
  double drag_coefficient = kNaN;    ///< C_D [-]
  double body_mass = kNaN;     ///< only for the share of mass that a tail adds, as the next [kg]
  double framing_mass = kNaN;  ///< of the tail's motor and mount, which stay with the body [kg]
  double tail_mass = kNaN;     ///< only for the torque that holds it level [kg]
  double tail_com = kNaN;      ///< distance of its centre of mass from the pin, likewise [m]
  double air_density = kNaN;   ///< [kg/m^3]
  model::DragKind drag =
      model::DragKind::rotation;  ///< none, rotation (equation 2) or distributed (equation 8)
  model::PlanarMotor motor;
  bool motor_limits = false;
  double drop = kNaN;                 ///< height of the fall [m]
  double duration = kNaN;             ///< in place of drop [s]
  double stroke = kNaN;               ///< tail angle at the stop [rad]
  double target = kNaN;               ///< body rotation to be timed [rad]
  double forward_speed = 0.0;         ///< of the body [m/s]
  double climb_speed = 0.0;           ///< of the body, upwards [m/s]
  double wind_forward = 0.0;          ///< of the air, along +x [m/s]
  double initial_tail_angle = 0.0;    ///< absolute: 0 up, positive leans forward [rad]
  double root_stiffness = kInfinity;  ///< [N m/rad]
  double scale = 1.0;                 ///< s [-]
  TailScaling tail_scaling = TailScaling::isometric;
  MotorScaling motor_scaling = MotorScaling::fixed;
};

/// One number of a setup.
struct Parameter {
  std::string name;    ///< "tail.length"
  std::string column;  ///< its column in study.csv, with unit: "tail_length_m"
  Dimension dimension;
  Bounds allowed;  ///< in SI
  double (*get)(const ReorientationSetup&);
  void (*set)(ReorientationSetup&, double);
  std::string meaning;
};

/// One choice of a setup.
struct Option {
  std::string name;  ///< "tail.drag"
  std::vector<std::string> choices;
  void (*set)(ReorientationSetup&, const std::string&);
  std::string meaning;
};

const std::vector<Parameter>& setup_parameters();
const std::vector<Option>& setup_options();

/// The parameter that a node names in text or as key; InputError at `where` with the nearest name
/// where there is none.
const Parameter& find_parameter(const std::string& name, const yaml::Node& where);

/// Sets one parameter or option from its value in a file.
void set_from(ReorientationSetup& setup, const std::string& name, const yaml::Node& value);

/// Reads a map of groups {body: {inertia: ...}, tail: {...}, ...} into a setup. Alternatives given
/// together: InputError.
ReorientationSetup read_setup(const yaml::Node& base);

/// What is missing or wrong, in a sentence for users; empty where the setup makes a case.
std::string check_setup(const ReorientationSetup& setup);

/// The case that a setup (check_setup: empty) describes, scaled.
ReorientationCase to_case(const ReorientationSetup& setup);

/// The torque that holds the tail level against gravity, m g l [N m]; NaN where mass or centre of
/// mass is not given.
double hold_torque(const ReorientationSetup& setup);

}  // namespace jaculus::studies
