#pragma once
// Residuals of one dataset about a noise model, as they come and as the prefix alone leaves them.
//
//   r = measured - predicted - A m: nuisances at their prior mean (noise/nuisances.h)
//   judged = r - A n_prefix, n_prefix: posterior mean from the rows of the prefix, so that no
//   nuisance is estimated on what is judged; its covariance gives `judged_deviation`.
// A row's weight is 1/(sigma sqrt(inflation)) (ChannelNoise::inflation).

#include <vector>

#include "diagnosis/noise/noise_model.h"

namespace jaculus::diagnosis {

struct ResidualRows {
  int dataset = 0;
  const ObservedDataset& observed;
  const Alignment& alignment;
  const std::vector<ChannelNoise>& channels;
  std::vector<RowSpan> spans;
  std::vector<const Prediction*> predictions;  ///< one a segment
  Vector judged;                               ///< in the channels' units
  Vector judged_deviation;  ///< standard deviation of `judged` by the nuisances' uncertainty
};

ResidualRows residual_rows(const Problem& problem, const NoiseModel& noise, int dataset);

}  // namespace jaculus::diagnosis
