#pragma once
// The generalised force that the model still lacks, in boxes of time, and the motion through each.
//
// Under a logged input the model runs from every measured state to the next, a box of time later,
// over all of every trial and not only the windows that it was fitted to. What is missing is the
// constant force under which the box ends with the rates measured,
//   f <- f + M(q) (v measured - v simulated under f)/h   until it stays.
// The first of these is not enough where a joint is at rest: friction takes up its own share of a
// push before the joint moves. States are those of parabolas through the samples within half a box
// (box_states.h), so that means over several boxes telescope and their noise falls with their
// number. No data are differentiated twice, and what a force may follow is taken along the model's
// own way through the box under f, which is a smoother of the data there.

#include <vector>

#include "diagnosis/forward/plant_forward.h"

namespace jaculus::diagnosis {

/// One box. Its path has kPathSamples + 1 samples, evenly from its start to its end.
struct MotionBox {
  int segment = 0, trial = 0;        ///< of its dataset
  double start = 0.0, length = 0.0;  ///< data's time [s]
  Vector force;                      ///< missing, a coordinate each [N m or N]
  Vector mean_rate;                  ///< measured, a coordinate each [rad/s or m/s]
  Vector mean_sign;                  ///< of a rate that goes evenly between those measured [-]
  Vector acceleration;               ///< measured [rad/s^2 or m/s^2]
  Vector model_acceleration;         ///< of the model as it is, without the force [same]
  Vector angles;                     ///< sines, then cosines of the bodies' angles at the end [-]
  Matrix q, v;                       ///< path, coordinates x samples [rad or m, and 1/s of that]
  Matrix torque;                     ///< motors x samples, one motor's at the joint [N m or N]
};
inline constexpr int kPathSamples = 8;

/// Boxes of every dataset, those of a trial in the order of time. `all`: the problem over windows
/// of a box that follow one another. A dataset that no logged input drives has none.
std::vector<std::vector<MotionBox>> motion_boxes(const Problem& all, const PlantForward& forward,
                                                 const Vector& p);

/// Mean over a path's samples by the trapezoidal rule, of a function of the sample.
template <class Function>
double path_mean(Eigen::Index samples, Function&& value) {
  double sum = 0.5 * (value(0) + value(samples - 1));
  for (Eigen::Index k = 1; k + 1 < samples; ++k) sum += value(k);
  return sum / static_cast<double>(samples - 1);
}

}  // namespace jaculus::diagnosis
