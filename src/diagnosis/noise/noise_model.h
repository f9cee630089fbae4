#pragma once
// The noise model about one point of the parameters: predictions there, clocks, nuisances of every
// segment and scatter of every channel. A value: later steps make another one about another point.

#include <map>
#include <string>
#include <vector>

#include "diagnosis/noise/channel_noise.h"
#include "diagnosis/noise/nuisances.h"
#include "diagnosis/noise/random_effects.h"

namespace jaculus::diagnosis {

/// Noise of one dataset.
struct DatasetNoise {
  std::vector<ChannelNoise> channels;
  std::vector<SegmentNuisances> nuisances;  ///< a segment each
};

struct NoiseModel {
  Vector p;                           ///< about which
  PredictionSet at_p;                 ///< not valid: there is no noise model
  std::vector<Alignment> alignments;  ///< a dataset each
  std::vector<DatasetNoise> datasets;
  bool may_lack = false;  ///< whether anything is granted beyond sensors and nuisances
  RandomColumns random;   ///< forces that it may be under a logged input; no columns elsewhere

  /// Flicker that the model which this is about needs in the logs that drive it, a joint each: the
  /// root of h, of which a log's own bound is granted at most (input_noise.h) [N m, N].
  std::map<std::string, double> flicker;

  [[nodiscard]] bool valid() const { return at_p.valid; }
};

/// Predicts at p, aligns streams, builds nuisances and estimates the scatter of every channel.
/// Alignment starts from the shifts of `from`, a dataset each (empty: from zero). Without random
/// effects. Not valid where the simulation fails.
NoiseModel estimate_noise(const Problem& problem, const Vector& p,
                          const std::vector<Alignment>& from = {});

/// The same with what the plant may lack, about its own point.
NoiseModel with_random_effects(const Problem& problem, NoiseModel noise);

/// Rows of all datasets by some predictions, aligned as the noise model has it.
std::vector<Vector> rows_of(const Problem& problem, const NoiseModel& noise,
                            const PredictionSet& predictions);

}  // namespace jaculus::diagnosis
