#pragma once
// Residuals of one condition about a linearisation, as they come and as its prefix alone leaves them.
//
//   r = measured - predicted - A m: nuisances at their prior mean (linearisation.h)
//   judged = r - A n_prefix, n_prefix: posterior mean from the rows before the end of the prefix, so that no nuisance is
//   estimated on what is judged; its covariance gives `judged_deviation`.
// A row's weight is 1/(sigma sqrt(inflation)), inflation = (1 + rho)/(1 - rho): samples for one independent one at a correlation rho
// of neighbours.

#include <functional>
#include <vector>

#include "jaculus/diagnosis/linearisation.h"

namespace jaculus {

struct ConditionRows {
  int index = 0;
  const Condition* condition = nullptr;
  std::vector<RowSpan> spans;
  std::vector<const Prediction*> predictions;  ///< one a run
  Vector predicted;                            ///< at the linearisation point, nuisances as aligned
  Vector residual;                             ///< r, in the channels' units
  Vector judged;
  Vector judged_deviation;  ///< standard deviation of `judged` by the nuisances' uncertainty, a row each
  Vector weight;            ///< 0 where a channel's noise isn't known
};

double channel_inflation(const Channel& channel);

ConditionRows condition_rows(const DiagnosisProblem& problem, const Linearisation& about, int c);

/// Simulates condition `c` at p with its set-up changed by `change`, and predicts its rows. False where a simulation fails.
bool predict_changed(const DiagnosisProblem& problem, const PlantForward& forward, int c, const Vector& p,
                     const std::function<void(RunSetup&)>& change, Vector& predicted);

}  // namespace jaculus
