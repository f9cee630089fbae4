#pragma once
// What a run's start does beyond its slopes: a foot that slips in one trial alone makes starts of some mrad act in jumps.
//   s: start offsets of run r by its nuisances on rows before the prefix' end, n = argmin |W (y - f - A n)|^2 + |(n - m)/s_n|^2
//   curvature = f(p; s) - f(p; 0) - A_s s,   taken off the run's recorded values, so that everything else stays linear in starts.
// Starts that the prefix does not tell stay near zero and so does their curvature.

#include "jaculus/diagnosis/linearisation.h"

namespace jaculus {

/// Takes it off the runs' values, which are as recorded. False where no run changed (no starts, or a logged input).
bool take_start_curvature(DiagnosisProblem& problem, const Linearisation& about, int c);

}  // namespace jaculus
