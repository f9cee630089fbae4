#pragma once
// What the scatter of a channel tells of its noise.
//
// Residual r at the noise model's point, per channel, on a hat basis over time that all segments
// share and the nuisances of each segment; what is left has sigma^2 = sum r^2/(N - rank) and
// correlation of neighbours rho = lag-1 autocorrelation + rank/N (the bias of a fit).
// Variability: where the segments' own leftovers, projected on 10 modes over time, hold three times
// what noise leaves there, a segment may go a smooth way of its own: 10 columns a channel with the
// standard deviation that the segments show.
// One segment alone: the hat basis is a smoother and sigma is its scatter, which sees no slow
// noise.

#include <vector>

#include "diagnosis/noise/nuisances.h"

namespace jaculus::diagnosis {

/// Noise of one channel of one dataset.
struct ChannelNoise {
  double noise_floor =
      kNaN;  ///< standard deviation of one trial about the mean after alignment [unit]
  double correlation = 0.0;  ///< of neighbouring samples of that scatter, 0 to 0.98 [-]
  double variability = 0.0;  ///< deviation of each smooth mode of a segment's own [unit]

  /// Samples for one independent one at this correlation, (1 + rho)/(1 - rho).
  [[nodiscard]] double inflation() const { return (1.0 + correlation) / (1.0 - correlation); }
};

/// Noise floor, correlation and variability of every channel; drops no channel: one without scatter
/// has a floor of zero. Nuisances are those without variability.
std::vector<ChannelNoise> channel_noise(const ObservedDataset& observed,
                                        const std::vector<const Prediction*>& predictions,
                                        const Alignment& alignment,
                                        const std::vector<SegmentNuisances>& nuisances,
                                        const Settings& settings);

}  // namespace jaculus::diagnosis
