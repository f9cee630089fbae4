#pragma once
// Logarithms of probabilities, exact where these themselves would be rounded to nothing.

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

/// log(e^a + e^b).
double log_of_sum(double a, double b);

/// log of the mass that a normal of this mean and deviation has within a range over that of the
/// standard normal, also where the range is far in a tail.
double log_mass_ratio(const Bounds& range, double mean, double deviation);

}  // namespace jaculus::diagnosis
