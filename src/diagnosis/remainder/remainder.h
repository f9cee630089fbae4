#pragma once
// What the judged model leaves, described: where, how large, and what it follows.

#include "diagnosis/remainder/motion_boxes.h"
#include "jaculus/diagnosis/held_out.h"
#include "jaculus/diagnosis/remainder.h"

namespace jaculus::diagnosis {

/// Share of the held-out gap's energy that the fitted model leaves, with Student's interval over
/// the folds; NaN where no gap can be judged.
void set_share(const HeldOut& gap, const Settings& settings, Remainder& remainder);

/// Every coordinate of the datasets' robots. `boxes`: motion_boxes() of `all`.
std::vector<RemainderPlace> described_places(const Problem& all,
                                             const std::vector<std::vector<MotionBox>>& boxes);

}  // namespace jaculus::diagnosis
