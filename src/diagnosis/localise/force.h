#pragma once
// The generalised force that the model lacks along the measured motion, where base and joints are
// both measured.
//
// Every `force_step` the state is measured by the smoother of windows.h. The model runs from each
// of them to the next; what the rate then misses, weighted by the mass matrix, is the impulse of
// the missing force over that time:
//     mean force = M(q) (v measured - v restarted)/h,     deviation from cov(v) at both ends.
// Second derivatives of the data never enter: one difference of rates that a parabola gave. Both
// states keep the feet in stance at rest, so forces that the floor takes up are out.
// Limits of validity: an impact within a step stays in its force; hinges and windings start each
// step at nominal.

#include <vector>

#include "diagnosis/forward/plant_forward.h"
#include "diagnosis/localise/departure.h"
#include "diagnosis/localise/rows.h"

namespace jaculus::diagnosis {

/// Empty where not every coordinate is measured, or where p has effects: the force is what the
/// nominal model lacks.
ForceResidual force_residual(const Problem& problem, const ResidualRows& rows,
                             const std::vector<DepartureChannel>& means,
                             const PlantForward& forward, const Vector& p);

}  // namespace jaculus::diagnosis
