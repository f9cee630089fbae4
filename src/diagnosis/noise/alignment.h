#pragma once
// Clocks: by how much the stamps of every stream of every segment are late.

#include <vector>

#include "diagnosis/forward/prediction.h"

namespace jaculus::diagnosis {

/// The shift d of every stream of every segment where the predictions fit best, within
/// settings.largest_shift, starting from `from`: Gauss-Newton on
///   sum_c m log |r_c(d)|^2 + (d/s)^2,   s = settings.shift_deviation, or settings.foreign_clock
///                                           where there is motion capture alone,
/// r_c the rows of a channel and m = settings.discrepancy_modes: what a model leaves has an unknown
/// size and is smooth, so that it counts as m independent values and not as its rows. A model that
/// is far off thus says little of clocks, one that fits dates them to its noise. Offsets of x and
/// pitch are free, other channels with an unknown zero begin as they show at rest. Values are as
/// recorded. Under a logged input, whose clock is the data's, nothing moves.
Alignment align(const ObservedDataset& observed, const std::vector<const Prediction*>& predictions,
                const Alignment& from, const Settings& settings);

}  // namespace jaculus::diagnosis
