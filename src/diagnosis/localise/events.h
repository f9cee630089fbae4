#pragma once
// Forces that acted once: a push, a cable that caught, a hand.
//
// Under a logged input the model that is stated runs from every measured state to the next, a box
// of time later, over all of every trial and not only the windows that it was fitted to; what the
// rate then misses, weighted by the mass matrix, is the mean of the force that is missing:
//   f = M(q) (v measured - v restarted)/h.
// Rates are those of parabolas through the samples within half a box, so that means over several
// boxes telescope and their noise falls with their number. Means over 1, 2, 4 and 8 boxes are
// compared with their usual size, the median of |mean| over 0.6745; an event is a run whose mean
// is beyond the normal quantile at `event_level` over all runs that were tried, the most unusual
// first. What usually is missing says how small an event may be. A rate that was measured wrongly
// at one instant pushes the boxes on both sides of it against one another, so a run counts by the
// nearest to zero of its sum and of those with a box more at either side. What another trial has
// at the same time comes with the motion and is no event. Limits of validity: a fault that comes
// and goes with the motion (cogging, a compliance that is not in the model) makes large forces
// usual; one that acts rarely looks like an event.

#include <vector>

#include "diagnosis/forward/plant_forward.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// Events about the parameters p, in the order of dataset, trial and time. `all`: the problem over
/// windows of a box that follow one another. Empty where a dataset is not driven by a logged
/// input.
std::vector<ForceEvent> force_events(const Problem& all, const PlantForward& forward,
                                     const Vector& p);

/// The forces of boxes that follow one another, of one joint in one trial.
struct ForceSeries {
  std::vector<double> time;   ///< middle of each box [s]
  std::vector<double> force;  ///< [N m] or [N]
};
/// A run of boxes that is an event.
struct EventRun {
  int series = 0, first = 0, last = 0;
  double deviations = 0.0;  ///< of its mean from zero, in usual sizes
};
/// Those of the series of one joint in all trials, the most unusual first.
std::vector<EventRun> unusual_runs(const std::vector<ForceSeries>& series, double level);

}  // namespace jaculus::diagnosis
