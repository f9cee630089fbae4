#pragma once
// Gains and feed-forward scale that a dataset leaves unknown: nuisances of the whole dataset. A
// gain is uniform over the range that the file states, without a bound at which a fit would stall,
//     gain = lower + (upper - lower) Phi(p),   p ~ N(0, 1),   Phi: the normal distribution,
// and what has no range is a factor exp(p) about a first value, p ~ N(0, spread^2).
//
// Datasets that state the same controller were run by one program and share their factors: one
// robot has one cause.
//
// A duty is a share of the bus voltage, which a file with unknown gains rarely knows any better:
// there the feed-forward has a factor too. It scales the voltage; what torque comes of that falls
// with speed (simulation/plant/drive.h), so that it is no scale of torque.
//
// Where motion capture is all that a dataset has, its clock is not the robot's: what it shows comes
// later than its stamps by p [s], p ~ N(0, foreign_clock^2), a clock for each dataset. As a
// nuisance of segments it would go by its slope, which is good for a part of a millisecond, about
// whatever the first model was aligned to.

#include <string>
#include <vector>

#include "diagnosis/data/observations.h"
#include "diagnosis/forward/hypotheses.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {

/// A nuisance that sets gains, scales the feed-forward or sets the clock of one dataset.
struct GainFactor {
  int parameter = -1;                ///< index in the hypotheses
  std::vector<std::string> streams;  ///< whose clock it is; empty: it is of the controller
  std::vector<int> motors;           ///< of the controller's reference; empty: the feed-forward
  bool derivative = false;           ///< kd, else kp
  std::vector<Bounds> ranges;        ///< one a motor, as stated; empty: factor exp(p)
};

/// Gains to begin with where a file states none, as the controller's quantity at the motor; the
/// middle of a stated range otherwise.
simulation::AssumedGains first_gains(const ObservedDataset& observed, const Settings& settings);

/// Phi: the share of a stated range that lies below the gain.
double share_of_range(double p);

/// Whether two datasets state the same loop, and with it the same unknowns.
bool same_controller(const trajectory::StatedController& a, const trajectory::StatedController& b);

/// Adds the nuisances of a dataset to the hypotheses, or takes those of the same name that are
/// there already; `suffix` tells controllers apart in their names.
std::vector<GainFactor> add_gain_factors(const ObservedDataset& observed,
                                         const simulation::Controller& controller,
                                         const std::string& suffix, const Settings& settings,
                                         Hypotheses& hypotheses);

/// Adds the clock of motion capture that is alone, named for the dataset if `several`; nothing of
/// other datasets.
std::vector<GainFactor> add_foreign_clock(const ObservedDataset& observed, bool several,
                                          const Settings& settings, Hypotheses& hypotheses);

/// Scales gains and feed-forward by the factors at p, and makes stamps late by its clocks.
void apply_factors(const std::vector<GainFactor>& factors, const Vector& p,
                   simulation::Plant& plant, simulation::Controller& controller);

}  // namespace jaculus::diagnosis
