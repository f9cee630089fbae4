#pragma once
// What a missing force may follow, as functions of the motion.
//
// A function phi of the motion enters by its mean over every box of time, taken along the model's
// way through the box (motion_boxes.h): the weak form of f = sum b phi (Messenger and Bortz 2021,
// "Weak SINDy"), in which no data are differentiated. Accelerations are the model's own without the
// missing force: measured ones have the force's noise in them. A sign counts in part below
// `rest_rate` of the joint's usual speed, tanh(v/rest).

#include <string>
#include <vector>

#include "diagnosis/remainder/motion_boxes.h"
#include "jaculus/diagnosis/remainder.h"

namespace jaculus::diagnosis {

/// Boxes in which the force along one coordinate is known, of all datasets that have it.
struct PlaceBoxes {
  std::string name;              ///< of the coordinate
  bool angular = true;           ///< [rad], else [m]
  std::vector<int> run;          ///< a box each: boxes of one run follow one another in a trial
  Vector force;                  ///< [N m or N]
  std::vector<Vector> position;  ///< path through each box [rad or m]
  double rest = 0.0;             ///< speed below which its sign counts in part [rad/s or m/s]
};

/// Functions that a force follows together.
struct RegressorGroup {
  Regressor regressor = Regressor::constant;
  std::string of{};
  Matrix columns;  ///< boxes x functions, of mean square 1
  Vector scale;    ///< by which each function was divided
};

struct PlaceRegressors {
  PlaceBoxes boxes;
  std::vector<RegressorGroup> groups;  ///< but the periodic ones, whose period is sought
};

/// Of one coordinate, by name, over all datasets. Groups that don't vary, or that an earlier group
/// spans, are left out.
PlaceRegressors regressors_of(const Problem& all, const std::vector<std::vector<MotionBox>>& boxes,
                              const std::string& coordinate);

/// Sine and cosine of position over a period, means over boxes.
Matrix periodic_columns(const PlaceBoxes& boxes, double period);

/// Periods that the motion could tell: even in 1/period, half of a cycle over the whole range
/// apart, from half of that range down to what most boxes resolve. Empty where there are none.
std::vector<double> periods_of(const PlaceBoxes& boxes);

}  // namespace jaculus::diagnosis
