#pragma once
// Gains and feed-forward scale that a dataset leaves unknown: nuisances of the whole dataset, each
// a factor exp(p) about a first value, p ~ N(0, spread^2).

#include <string>
#include <vector>

#include "diagnosis/data/observations.h"
#include "diagnosis/forward/hypotheses.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {

/// A nuisance that scales gains or the feed-forward of one dataset: factor exp(p).
struct GainFactor {
  int parameter = -1;       ///< index in the hypotheses
  std::vector<int> motors;  ///< of the controller's reference; empty: the feed-forward
  bool derivative = false;  ///< kd, else kp
};

/// Gains to begin with where a file states none, as the controller's quantity at the motor; the
/// middle of a stated range otherwise.
simulation::AssumedGains first_gains(const ObservedDataset& observed, const Settings& settings);

/// Adds the nuisances of a dataset to the hypotheses; `suffix` tells datasets apart in their names.
std::vector<GainFactor> add_gain_factors(const ObservedDataset& observed,
                                         const simulation::Controller& controller,
                                         const std::string& suffix, const Settings& settings,
                                         Hypotheses& hypotheses);

/// Scales gains and feed-forward by the factors at p.
void apply_factors(const std::vector<GainFactor>& factors, const Vector& p,
                   simulation::Plant& plant, simulation::Controller& controller);

}  // namespace jaculus::diagnosis
