#pragma once
// Nuisances of one run by its own rows.

#include "jaculus/diagnosis/linearisation.h"

namespace jaculus {

/// Most probable deviation d of a run's nuisances from their prior mean, by rows of weights w (1/deviation; 0: left out):
///   d = argmin |w (r - A d)|^2 + |d/s|^2,   r: residual of the run's rows less A m.
Vector nuisance_deviation(const RunNuisances& n, const Vector& r, const Vector& weight);

}  // namespace jaculus
