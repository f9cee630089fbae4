#pragma once
// Torque, current and voltage of a sampled loop are staircases: the command that arrives at a_j =
// late start + delay + j/rate holds to a_(j+1). Read at the points of a grid, and linear between
// them, they would be early by half a period where arrivals and points coincide, and would jump by
// a period once a delay parts the two. So they are read in the middle of every hold (of every part
// of it no longer than a cell) and a point gets their mean over its cell,
//
//   y_k = 1/|C_k| sum_i |C_k n H_i| y(middle of H_i),
//   C_k = [t_k - h/2, t_k + h/2] within [0, end],
//
// which is continuous in the arrivals. Drift within a hold is left out beyond first order.

#include "jaculus/simulation/simulate.h"

namespace jaculus::diagnosis {

/// simulate() with evenly spaced options.sample_times; torque, current, voltage and bus voltage of
/// a sampled loop are the means above.
simulation::Simulation simulate_on_grid(const simulation::Plant& plant,
                                        const simulation::Controller& controller,
                                        const simulation::StartState& start,
                                        const simulation::SimulationOptions& options);

}  // namespace jaculus::diagnosis
