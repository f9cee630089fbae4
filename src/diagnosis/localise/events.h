#pragma once
// Forces that acted once: a push, a cable that caught, a hand.
//
// Under a logged input the model that is stated runs from every measured state to the next, a box
// of time later, over all of every trial and not only the windows that it was fitted to. What is
// missing is the constant force under which the box ends with the rates measured,
//   f <- f + M(q) (v measured - v simulated under f)/h   until it stays.
// The first of these is not enough where a joint is at rest: friction takes up its own share of a
// push before the joint moves. Rates are those of parabolas through the samples within half a box,
// so that means over several boxes telescope and their noise falls with their number. Pulses in
// this force are told from what usually is missing by pulses.h, which may follow the friction at
// the joint and the bodies' weights, and is larger in fast motion.

#include <vector>

#include "diagnosis/forward/plant_forward.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// Events about the parameters p, in the order of dataset, trial and time. `all`: the problem over
/// windows of a box that follow one another. Empty where a dataset is not driven by a logged
/// input.
std::vector<ForceEvent> force_events(const Problem& all, const PlantForward& forward,
                                     const Vector& p);

}  // namespace jaculus::diagnosis
