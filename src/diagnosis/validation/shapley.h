#pragma once
// How players share what they are worth together: the mean over the orders in which they may join
// (Shapley 1953).

#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

/// Shapley values of n players, v[subset] the worth of each subset of them (bit k: player k takes
/// part).
Vector shapley_values(const std::vector<double>& v, int n);

}  // namespace jaculus::diagnosis
