#pragma once
// From a selection among models to what is stated: verdict, effects with parameters, ranking, held-out gap.

#include "jaculus/diagnosis/diagnose.h"

namespace jaculus {

/// Fills verdict, effects, ranking, gap and the chosen model of `out`.
void state_findings(const DiagnosisProblem& problem, const Linearisation& about, const EvidenceSpace& space,
                    Selection selection, Diagnosis& out);

}  // namespace jaculus
