#pragma once
// What sensors add to what happened: noise that is neither white nor normal, steps of a converter,
// a filter, a clock that runs at another rate.
//
//   n_k = sd ( sqrt(1 - c) w_k + sqrt(c) a_k ),   a_k = r a_{k-1} + sqrt(1 - r^2) w'_k,
//   r = exp(-dt/T)
// w is Student's t of `tails` degrees of freedom, scaled to unit variance (normal where tails is
// 0); c the coloured share, T its correlation time. Variance is sd^2 whatever c, T and tails are.

#include <random>

#include "jaculus/core/types.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::testbed {

/// Adds noise of standard deviation `sd` to samples `dt` [s] apart.
void add_noise(Vector& values, double sd, double dt, const NoiseShape& shape,
               std::mt19937_64& random);

/// Rounds to whole steps of a converter; a step of 0 leaves all as it is.
void quantise(Vector& values, double step);

/// First-order low pass of time constant `time` [s] on samples `dt` [s] apart, at rest on the first
/// sample before it; a time of 0 leaves all as it is.
void low_pass(Vector& values, double time, double dt);

}  // namespace jaculus::testbed
