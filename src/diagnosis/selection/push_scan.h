#pragma once
// Pushes under a plan: forces that acted once, at the same time in every trial, as a cable that
// catches or a hand does. Where they may have acted is told by linear algebra, from the slopes F of
// the rows by forces that are constant over narrow boxes of time.
//
// A push along one coordinate, A sin(pi (t - t_0)/L) from t_0 to t_0 + L, has over box k of time
// the mean
//   s_k = (1/h) int sin = (L/(pi h)) [cos(pi (a - t_0)/L) - cos(pi (b - t_0)/L)],
// a and b the ends of the box within the push, so that its column is F s. Of all starts and lengths
// each coordinate's best, by the evidence of
//   r0 = N n + A F s + G w + e,   A ~ N(0, 1) in forces that count as large
// (noise/random_effects.h), by the deviations of w that it needs. What is found becomes a candidate
// beside the effects of the catalogue (push_effect), simulated, with its time and length fitted,
// and has to lead like any other.

#include <string>
#include <vector>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/fit.h"

namespace jaculus::diagnosis {

struct LikelyPush {
  std::string coordinate;
  double start = 0.0, length = 0.0;  ///< [s]
  double peak = 0.0;                 ///< [N m or N]
  double gain = 0.0;                 ///< log evidence beyond that of no push
};

/// How long the boxes of a scan are [s].
double scanned_box(const Problem& problem);

/// The best push along each coordinate about a fit, of those that gain evidence, best
/// first, `most` at most.
/// Under a plan alone, of one dataset: pushes of several have nothing in common. `narrow`: the same
/// problem with scanned_box as settings.force_box.
std::vector<LikelyPush> likely_pushes(const Problem& problem, const Problem& narrow,
                                      const Comparison& comparison, const Fit& about, int most);

/// That push as an effect of three parameters: peak [N m or N], middle and length [s]. Within the
/// `duration` [s] of the motion its middle may be anywhere (a normal prior about where it was found
/// of a uniform one's deviation, duration/sqrt(12)).
effects::Effect push_effect(const Problem& problem, const LikelyPush& push, double duration);

}  // namespace jaculus::diagnosis
