#pragma once
// Forces that acted once: a push, a cable that caught, a hand.
//
// Under a logged input every window has the forces that the plant lacks as random effects
// (noise/random_effects.h). About the model that is stated, over all of every trial and not only the
// windows that it was fitted to, their posterior mean is the force that is missing in every box of
// time,
//   f = D w,   w = S (I + S G^T G S)^-1 S G^T r.
// Means over 1, 2, 4 and 8 boxes are compared with their usual size, the median of |mean| over
// 0.6745; an event is a run whose mean is beyond the normal quantile at `event_level` over all runs
// that were tried, the most unusual first. What usually is missing says how small an event may be.
// Limits of validity: a fault that comes and goes with the motion (cogging, a compliance that is not
// in the model) makes large forces usual; one that acts rarely looks like an event.

#include <vector>

#include "diagnosis/forward/problem.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// Events about the parameters p, in the order of dataset, trial and time. `all`: the problem over
/// every window of its data. Empty where a dataset is not driven by a logged input.
std::vector<ForceEvent> force_events(const Problem& all, const Vector& p);

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
