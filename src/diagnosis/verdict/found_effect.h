#pragma once
// Effects and tolerances of fitted models, as users read them.

#include <vector>

#include "diagnosis/selection/posterior.h"
#include "diagnosis/verdict/proposal.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// An effect as `model` fitted it, or the most probable model that has it. `others`: what may stand
/// in for it. Intervals have what its form on hardware may differ by (settings.form_error).
FoundEffect found_effect(const Problem& problem, const Whitening& whitening,
                         const Posterior& posterior, int c, const ModelFit* model,
                         const std::vector<int>& others);

/// Widens the intervals of an effect by those it has where a rival stands in another member's
/// place: which of the two it is can't be told, so that either value may be right.
void widen_by_rivals(const Problem& problem, const Whitening& whitening, const Posterior& posterior,
                     const ModelFit& chosen, const std::vector<Established>& named, int c,
                     FoundEffect& effect);

/// Values of a model's effects, without intervals.
std::vector<FoundParameter> values_of(const Problem& problem, const ModelFit& model);

/// Tolerances by which a fit is a deviation off its files or more, and surely off them, the
/// farthest first.
std::vector<Tolerated> tolerated_by(const Problem& problem, const Fit& fit);

}  // namespace jaculus::diagnosis
