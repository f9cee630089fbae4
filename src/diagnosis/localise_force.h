#pragma once
// The generalised force that the model lacks along the measured motion, where base and joints are both measured.
//
// Every 20 ms the state is measured by the smoother of localise_windows.h. The model runs from each of them to the next; what the rate
// then misses, weighted by the mass matrix, is the impulse of the missing force over that time:
//     mean force = M(q) (v measured - v restarted)/h,     deviation from cov(v) at both ends.
// Second derivatives of the data never enter: one difference of rates that a parabola over 30 ms gave. Both states keep the feet in
// stance at rest, so forces that the floor takes up are out. What a component could have exerted there comes from the catalogue: the
// same restarts with each effect at its probe; the missing rates are shared among them as the signatures are (localise_shares.h).
// Limits of validity: an impact within a step stays in its force; hinges and windings start each step at nominal.

#include <vector>

#include "diagnosis/localise_departure.h"
#include "diagnosis/localise_rows.h"
#include "diagnosis/localise_signatures.h"

namespace jaculus {

struct ForceAnswer {
  ForceResidual residual;                  ///< empty where not every coordinate is measured
  std::vector<ComponentShare> components;  ///< likewise
};

ForceAnswer force_residual(const DiagnosisProblem& problem, const ConditionRows& rows,
                           const std::vector<DepartureChannel>& means, const PlantForward& forward, const Vector& p,
                           std::uint64_t seed);

}  // namespace jaculus
