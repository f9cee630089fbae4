#pragma once
// Channels whose sign or unit contradicts the prediction, before any effect is looked for.

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/noise/noise_model.h"

namespace jaculus::diagnosis {

/// One sentence each ("pitch looks inverted"): measured against predicted over all segments, means
/// removed, correlation c and slope b. Inverted: c below settings.inverted_below and -f fits three
/// times better than f. Another unit: c above settings.scaled_above and b within
/// settings.unit_tolerance of 180/pi, 1000 or their inverses. Only where the motion is
/// settings.motion_above_noise times the noise.
std::vector<std::string> contradictions(const Problem& problem, const NoiseModel& noise);

/// The observations with what drives their models of the other sign; nothing where no log does.
std::optional<Observations> with_inputs_inverted(const Observations& observations);
/// A sentence where the model is three times nearer to the motion by inverted inputs, as a
/// deviation over all windows and channels of motion in noise floors (settings.inverted_gain of
/// their squares); else empty. `inverted`: the problem of with_inputs_inverted().
std::string inverted_inputs(const Problem& problem, const NoiseModel& noise,
                            const Problem& inverted);

}  // namespace jaculus::diagnosis
