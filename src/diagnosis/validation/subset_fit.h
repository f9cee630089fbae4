#pragma once
// Fits of subsets of a fitted set of effects.

#include "diagnosis/selection/posterior.h"
#include "diagnosis/selection/search.h"

namespace jaculus::diagnosis {

/// The model of `members`, a subset of a model's: as the search fitted it, else fitted from the
/// larger one with the others at nominal.
ModelFit fitted_subset(const Problem& problem, const Comparison& comparison,
                       const Posterior& posterior, const ModelFit& model,
                       const std::vector<int>& members);

}  // namespace jaculus::diagnosis
