#pragma once
// Noise of a logged input.
//
// A torque or a current that was logged is a measurement: the model is driven by it as it was
// recorded, scatter and all, while the robot was driven by what the log meant to show. So a window
// differs from its prediction, with nothing wrong, by what a force at the joint does that is as
// large as the log's scatter:
//   y = f + G w + ...,   w_k ~ N(0, s^2/n) of every box of time,   s: of a sample, n samples a box,
// G the rows' slopes by such forces. As nuisances of the windows these serve all models alike, and
// what a perfect model leaves of held-out rows has them too.
//
// s is told by the log itself (data/scatter.h).

#include <map>
#include <string>

#include "diagnosis/noise/nuisances.h"

namespace jaculus::diagnosis {

/// Noise of the log of each motor that has one, as a force at its joint over a box of time of
/// settings.force_box [N m, N where it slides]; a joint each. Empty where no input was logged.
std::map<std::string, double> input_noise(const ObservedDataset& observed,
                                          const Settings& settings);

/// The nuisances of a window and those of its input's noise. `slopes`: of the window's rows by the
/// boxes of all forces in their order, a prior scale each (random_effects.h).
SegmentNuisances with_input_noise(SegmentNuisances nuisances, const Hypotheses& hypotheses,
                                  const std::map<std::string, double>& noise, const Matrix& slopes);

}  // namespace jaculus::diagnosis
