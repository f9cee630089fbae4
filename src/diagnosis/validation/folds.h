#pragma once
// Folds of a cross-validation.

#include <string>
#include <vector>

#include "diagnosis/noise/whitening.h"

namespace jaculus::diagnosis {

/// Masks of training segments.
struct Folds {
  std::string over;                ///< "conditions" (datasets), "trials", "time"
  std::vector<SegmentMask> masks;  ///< empty where nothing can be held out
};
Folds folds_of(const Observations& observations, const Settings& settings);

}  // namespace jaculus::diagnosis
