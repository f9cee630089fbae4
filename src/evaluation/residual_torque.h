#pragma once
// Torque that the nominal model lacks at each motor's joint, along the measured motion, and the
// terms that a sparse regression may make it of.
//
// As diagnosis/localise/force.h does it, segment by segment and by the stamps as they are: the
// state is measured every
// `force_step` by the smoother of localise/windows.h, the model runs from each to the next, and
// what the rate then misses, times the mass matrix and over the step, is the missing force.
// Contacts, motors and feedback are the model's own in that step, so that it serves robots that
// stand as well as those on a fixed base; on the latter it is the residual of inverse dynamics.

#include <array>
#include <string>
#include <vector>

#include "evaluation/baseline_problem.h"

namespace jaculus::evaluation {

/// A column of the library.
enum class TorqueTerm { constant, sign, speed, speed_cubed, acceleration, sine, cosine, command };
inline constexpr int kTorqueTerms = 8;

struct JointTorque {
  std::string joint;
  Vector torque;     ///< that the model lacks, a step each [N m or N]
  Vector deviation;  ///< of it by measurement noise [same]
  /// steps x terms: 1, tanh(speed/0.1 rad/s), speed, its cube, acceleration of the nominal
  /// model, sine and cosine of the link's absolute angle, torque of the model's motor; SI
  Matrix library;
};

/// Of every motor's joint. Empty where a coordinate of the robot is not measured, or no step is.
std::vector<JointTorque> residual_torques(const BaselineProblem& ready);

/// The effect of the catalogue that a term at a joint stands for; empty where there is none.
std::string effect_of_term(const diagnosis::Hypotheses& hypotheses, const model::PlanarModel& model,
                           const std::string& joint, TorqueTerm term);

}  // namespace jaculus::evaluation
