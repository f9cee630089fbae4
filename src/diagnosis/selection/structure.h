#pragma once
// Structure: does what a model leaves hold smooth shapes?
//
// z = Q^T r with Q an orthonormal basis of T D (fault modes of every channel, K = 10), the model's
// own sensitivities projected out. Against N(0, I): z ~ N(0, (1 + a^2) I), a unknown,
//     log BF = log mean over a^2 in {1, 3, 10, ... 1e5} of
//              (1 + a^2)^(-k/2) exp(|z|^2 a^2/(2 (1 + a^2))).
// Segments that share a command share their modes; windows under a logged input are different
// motions, and each has modes over its own time.

#include "diagnosis/selection/fit.h"

namespace jaculus::diagnosis {

/// log Bayes factor of smooth unknown structure in what a fit leaves.
double structure_evidence(const Problem& problem, const NoiseModel& noise,
                          const Whitening& whitening, const Fit& fit);

}  // namespace jaculus::diagnosis
