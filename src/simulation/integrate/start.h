#pragma once
// States that sensors show.

#include "jaculus/simulation/simulate.h"

namespace jaculus::simulation {

/// The state of a plant whose encoders show `read`: joints with motors less the encoders' offsets
/// and by their scales, rates by the same scales. A joint that would be beyond its stop rests
/// against it, unless it was read there.
StartState state_as_read(const Plant& plant, const StartState& read);

}  // namespace jaculus::simulation
