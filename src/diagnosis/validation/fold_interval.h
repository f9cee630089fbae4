#pragma once
// What folds tell of the uncertainty of a figure.

#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

/// 95 % interval about `value` by Student's t over its values by fold, of which those that are not
/// finite don't count; NaN where fewer than two are left.
Bounds fold_interval(const std::vector<double>& by_fold, double value);

}  // namespace jaculus::diagnosis
