#pragma once
// Forces that a robot may lack, each at one place and of one form, as effects (jaculus-effect/1):
// what a description tries where no force can be had box by box, and what competes with the
// catalogue (search_with_forces.h). At a motor's joint or a group of them the forms are those of
// regressors.h, and three of what may become of a motor's torque on its way: a loss that grows with
// the torque, with time, or has its sign. On the body forces along x and z and a moment that are
// constant, grow with the way from the start (at once or from a slack on), with the speed and its
// square, with time, or repeat in time. At a foot what acts within kNearFloor of the floor: a
// constant along z and x, a spring from there down, friction. Every form is linear in its
// parameters, all zero at nominal:
//   f(q, v, tau, t) = sum_k b_k phi_k(q, v, tau, t).
// Periods, slacks and where springs rest are constants of a pattern; a hypothesis (file) frees
// periods and slacks. Scales, the deviations of the prior, are `pattern_prior` of a force that
// counts as large at the place, over the usual size of what it follows.

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
};

struct PlacePattern {
  std::string place, at;  ///< as of RemainderPlace
  Regressor regressor = Regressor::constant;
  double period = kNaN;       ///< [period_unit]
  double slack = kNaN;        ///< of a cable [m]
  std::string period_unit{};  ///< "rad", "m", "s"
  std::string name{};         ///< of the effect
  std::string caption{};
  std::string where{};  ///< value of `at:`
  std::vector<PatternParameter> parameters{};
  std::vector<std::string> constants{};  ///< lines
  std::vector<std::string> formulas{};   ///< lines
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
};

/// Those of a robot. `prior`: share of a large force; `lever` [m] as of large_force().
std::vector<PlacePattern> place_patterns(const model::PlanarModel& robot, const UsualMotion& usual,
                                         double prior, double lever, double rest_speed);

}  // namespace jaculus::diagnosis
