#pragma once
// Sensors: what they make of a simulated motion, with noise, gaps and clocks of their own.

#include "jaculus/simulation/experiment.h"
#include "simulation/experiment/random.h"

namespace jaculus::simulation {

/// Time between samples of the true motion, from the command's start on [s].
inline constexpr double kTruthStep = 5e-4;

/// What a stream shows of `truth`, which has a sample each kTruthStep.
trajectory::Stream read_sensor(const Experiment& experiment, const SensorStream& spec,
                               const Plant& plant, const Simulation& truth, Random& random);

}  // namespace jaculus::simulation
