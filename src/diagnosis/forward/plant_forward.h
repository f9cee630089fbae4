#pragma once
// Forward model of a diagnosis: parameters in, predicted channels out, by simulation of the plant.

#include <functional>
#include <vector>

#include "diagnosis/forward/problem.h"
#include "jaculus/simulation/simulate.h"

namespace jaculus::diagnosis {

/// How a segment is simulated, for those who need more than channels (localisation).
struct SimulationSetup {
  simulation::Plant plant;
  simulation::Controller controller;
  simulation::StartState start;
  simulation::SimulationOptions options;
};

/// Hypotheses (which effects these robots can have, unknown gains, starts) and the forward model of
/// observations, which it keeps a copy of.
struct PlantForward {
  Hypotheses hypotheses;
  ForwardModel predict;
  TolerancePart tolerance_part;
  /// Set-up of a segment at parameters p.
  std::function<SimulationSetup(int dataset, int segment, const Vector& p)> setup;
};
PlantForward plant_forward(const Observations& observations,
                           const std::vector<const effects::Effect*>& effects,
                           const Settings& settings);

}  // namespace jaculus::diagnosis
