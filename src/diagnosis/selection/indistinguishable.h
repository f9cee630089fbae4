#pragma once
// Candidates that the data can't tell from a fitted single: whose columns, at either strength of
// screening, reproduce its signature beside the nuisances.

#include <vector>

#include "diagnosis/selection/fitted_models.h"

namespace jaculus::diagnosis {

/// Fits whatever can't be told from the best single, best by screening first.
void fit_indistinguishable(const Settings& settings, const RandomEffects& random,
                           const std::vector<Probe>& probes, FittedModels& models);

/// A candidate each: itself, then what can't be told from it; empty where it was not fitted alone.
/// `below`: energy of a signature that says nothing [nats].
std::vector<Members> indistinguishable_sets(const RandomEffects& random, const FittedModels& models,
                                            const std::vector<Probe>& probes, double below);

}  // namespace jaculus::diagnosis
