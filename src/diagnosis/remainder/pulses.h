#pragma once
// Pulses in a series of missing forces, told from how a model is usually wrong.
//
// A box k of time lacks the force
//   f_k = x_k . b + sum over pulses of A sin(pi (t - t_0)/L) + e_k,   e_k ~ t_4(0, m_k),
//   m_k = p_k . c,  c >= 0.
// x: functions of the motion that forces which are wrong follow (a friction, a weight); p: what
// makes them wrong by more (fast motion, hard acceleration). b and c are the most probable ones of
// Student's t with 4 degrees of freedom, as a scale mixture of normals (Lange, Little and Taylor,
// 1989): in turn weights 5/(4 + e^2/m), b by weighted least squares, and c by the multiplicative
// step that raises a normal's likelihood,
//   c_j <- c_j sqrt(sum_k p_kj w_k e_k^2/m_k^2 / sum_k p_kj/m_k)
// (Fevotte, Bertin and Durrieu, 2009). A pulse of a length is told by its matched filter,
//   A = sum s f/m / sum s^2/m,   z = A sqrt(sum s^2/m) / (usual size of that over all boxes),
// the usual size, a median of |.| over 0.6745, being what the colour of e makes of it. A rate that
// was measured wrongly at one instant pushes the boxes on both sides of it against one another, so
// a pulse counts by the nearest to zero of its z and those of the mean force over its boxes, and
// over these and one more at either side. What acts at the same time in every trial is told from
// the mean over trials too, weighted by 1/m: independent errors are less there by the root of their
// number; where the model is wrong alike in every trial, it is the mean's own usual size that
// counts. What is found there is a pulse of every trial if most have half of it. Limits of
// validity: a fault that comes and goes with the motion and isn't in x or p (cogging, a compliance)
// makes large forces usual; one that acts rarely looks like a pulse.

#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

/// The force that is missing along one coordinate in boxes of time, trial by trial.
struct ForceBoxes {
  double length = 0.0;     ///< of a box [s]
  std::vector<int> trial;  ///< of each box; boxes of a trial are in the order of time
  Vector time;             ///< middle of each box [s]
  Vector force;            ///< [N m] or [N]
  Matrix follows;          ///< boxes x functions x of the motion; the first column is one
  Matrix spreads;          ///< boxes x functions p >= 0 of the motion; the first column is one
};

/// How a model is usually wrong.
struct UsualForce {
  Vector residual;  ///< force - x . b [N m] or [N]
  Vector variance;  ///< m [N^2 m^2] or [N^2]
};
UsualForce usual_force(const ForceBoxes& boxes);

struct Pulse {
  int first = 0, last = 0;   ///< boxes
  double peak = 0.0;         ///< A [N m] or [N]
  double probability = 0.0;  ///< that what usually is missing doesn't make it anywhere
  bool every_trial = false;  ///< the others have half of it or more at the same time
};
/// Pulses beyond the normal quantile at `level` over all that were tried, the most unusual first.
/// What every trial has is listed once. None in less than 40 boxes, whose usual size is hardly
/// known.
std::vector<Pulse> unusual_pulses(const ForceBoxes& boxes, double level);

}  // namespace jaculus::diagnosis
