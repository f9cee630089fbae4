#pragma once
// Clocks: by how much the stamps of every stream of every segment are late.

#include <vector>

#include "diagnosis/forward/prediction.h"

namespace jaculus::diagnosis {

/// The shift of every stream of every segment where the predictions fit best, within
/// settings.largest_shift, starting from `from`. Gauss-Newton on the shift, offsets of x and pitch
/// free, of other channels with an unknown zero as they show at rest, every channel in units of its
/// own misfit. Values are as recorded. Under a logged input, whose clock is the data's, nothing
/// moves.
Alignment align(const ObservedDataset& observed, const std::vector<const Prediction*>& predictions,
                const Alignment& from, const Settings& settings);

}  // namespace jaculus::diagnosis
