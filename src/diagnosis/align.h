#pragma once
// First steps of a linearisation: shifts of streams and noise floors (formulas in jaculus/diagnosis/linearisation.h).

#include <vector>

#include "jaculus/diagnosis/linearisation.h"

namespace jaculus {

/// Sets the shift of every stream of every run to where the predictions fit best, within 30 ms. Gauss-Newton on the shift, offsets
/// of x and pitch free, every channel in units of its own misfit.
void align(Condition& condition, const std::vector<const Prediction*>& predictions);

/// Sets noise floor and correlation of every channel; drops no channel: one without scatter keeps a floor of zero.
void estimate_noise(Condition& condition, const std::vector<const Prediction*>& predictions,
                    const std::vector<RunNuisances>& nuisances);

}  // namespace jaculus
