#pragma once
// Forces that a robot may lack, each at one place and of one form, as effects (jaculus-effect/1):
// what a description tries where no force can be had box by box, and what competes with the
// catalogue (search_with_forces.h).
//
// At a motor's joint, or at all of a limb's or an arm's, the forms are those of regressors.h, and
// - of friction: at one place, fading with the way, of bristles that bend before they slip;
// - of what becomes of a motor's torque on its way: a loss that grows with the torque, with time,
//   or has its sign, a part lost from some time on, a change held back, a gear out of round;
// - springs, also of one side, from some place on; at one joint what turns with gravity.
// On the body forces along x and z and a moment that are constant, grow with the way from the start
// (at once or from a slack on), with the speed and its square, with time, or repeat in time, and a
// mass that hangs in it on a spring. At a foot what acts within kNearFloor of the floor: a constant
// along z and x, a spring from there down, friction.
//
// Every form is linear in its parameters, all zero at nominal, s states of its own:
//   f(q, v, tau, t) = sum_k b_k phi_k(q, v, tau, s, t).
// What a form isn't linear in, its shape, is a constant from a grid; a hypothesis (file) frees it.
// Scales, the deviations of the prior, are `pattern_prior` of a force that counts as large at the
// place, over the usual size of what it follows; of joints together so many limits of each motor.

#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/diagnosis/remainder.h"
#include "jaculus/model/planar.h"

namespace jaculus::diagnosis {

/// A parameter b_k.
struct PatternParameter {
  std::string name, unit;
  double scale = 1.0;
  double lower = -kInfinity, upper = kInfinity;  ///< what it can be at all [unit]
};

/// A number that a form isn't linear in: a period, from where a spring acts, a width.
struct PatternShape {
  std::string name, unit;
  double value = 1.0;               ///< [unit]
  double scale = 1.0;               ///< deviation of its prior where a file frees it [unit]
  double lower = 0.0, upper = 1.0;  ///< [unit]
};
/// Within a fifth, for the next period of a grid is the next one's.
PatternShape period_shape(const std::string& unit, double period);
/// From nothing on; `range` of what moves.
PatternShape slack_shape(const std::string& unit, double slack, double range);
/// Within a factor of three.
PatternShape width_shape(const std::string& unit, double width);

struct PlacePattern {
  std::string place, at;  ///< as of RemainderPlace
  Regressor regressor = Regressor::constant;
  std::string name{};  ///< of the effect
  std::string caption{};
  std::string where{};  ///< value of `at:`
  std::vector<PatternParameter> parameters{};
  std::optional<PatternShape> shape{};
  std::vector<std::string> constants{}, values{}, states{}, formulas{};  ///< lines of the file
  std::string form{};   ///< in words, where the regressor says only what it depends on
  bool listed = false;  ///< the catalogue has an effect that is the same at a joint
};

/// How coordinates or joints move in the data, one each.
struct UsualMotions {
  Vector start;  ///< [rad or m]
  Vector speed;  ///< root mean square [rad/s or m/s]
  Vector range;  ///< largest less least position [rad or m]
};

/// How a robot does. A leg's motors turn joints that are no coordinates.
struct UsualMotion {
  UsualMotions coordinates, motors;
  double duration = 1.0;  ///< [s]
};

struct PatternSizes {
  double prior = 0.3;        ///< of a large force, deviation of a form's [-]
  double lever = 0.1;        ///< as of large_force() [m]
  double rest_speed = 0.02;  ///< of the usual speed, below which its sign counts in part [-]
};

/// Value of `at:` of a force on the base, at its centre of mass.
std::string base_place(const model::PlanarModel& robot);

/// Those of a robot.
std::vector<PlacePattern> place_patterns(const model::PlanarModel& robot, const UsualMotion& usual,
                                         const PatternSizes& sizes);

}  // namespace jaculus::diagnosis
