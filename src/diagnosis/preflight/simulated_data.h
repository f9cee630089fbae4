#pragma once
// Data of an experiment with some effects at work, as `simulate` makes them.

#include <optional>
#include <vector>

#include "jaculus/effects/effect.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {

/// An explanation of data: effects, and a value for each of their parameters.
struct Explanation {
  std::vector<const effects::Effect*> effects;
  std::vector<Vector> theta;  ///< parameters of each, own units
};

/// Trials of an experiment on the plant with an explanation's effects, those that the robot can't
/// have left out; nothing where the plant is lost.
std::optional<trajectory::Dataset> simulated_data(const simulation::Experiment& experiment,
                                                  const Explanation& explanation);

}  // namespace jaculus::diagnosis
