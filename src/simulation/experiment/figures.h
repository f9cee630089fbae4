#pragma once
// The state of a leap at an instant, for its figures and for margins.

#include <optional>

#include "jaculus/simulation/experiment.h"

namespace jaculus::simulation {

/// At `time` [s]; `height`: of the base at touchdown [m], for the landing pitch.
LeapState state_at(const model::PlanarModel& model, const Simulation& s, double time,
                   const std::optional<double>& height);

}  // namespace jaculus::simulation
