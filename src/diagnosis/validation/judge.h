#pragma once
// Errors of a prediction of held-out segments, in noise floors and in the channels' units.
//
// A segment's own nuisances (shift, start, offsets) are estimated from its prefix alone,
//   n = argmin |W (y - f - A n)|^2 over rows of the prefix + |(n - m)/s|^2,
// and rows after it are judged. P: covariance of n that the prefix leaves.
//   noise floors  e_i = (y - f - A n)_i/sqrt(v_i),  v_i = sigma_i^2 (1 + 1/n_train) + (A P A^T)_ii
//   units         (y - f - A n)_i, beside v_i, which is what a perfect model is expected to leave
// A dataset of which a fold knows nothing is predicted by a robot whose tolerances and unknown
// gains only the other datasets tell: with S = (J^T J + I)^-1 their covariance by these, J the
// white slopes there and B the slopes here, less what n takes of them, v_i has (B S B^T)_ii in
// place of sigma_i^2/n_train. S is a model's that lacks nothing, the same for all models, so that a
// vague one gains nothing by being vague.
//
// Horizon h: the segment is judged as if it ended at h after its start, its prefix being
// settings.prefix_share of that. The start is that of the command, or of a window under a logged
// input, which restarts the model from measured coordinates. An infinite horizon is the whole
// motion (the whole window).

#include <vector>

#include "diagnosis/noise/whitening.h"

namespace jaculus::diagnosis {

/// Horizons at which errors are stated in units [s]: the whole motion, settings.horizon.
std::vector<double> horizons_of(const Settings& settings);

/// Sums over judged rows of one channel at one horizon.
struct UnitSums {
  double squares = 0.0;   ///< of errors [unit^2]
  double variance = 0.0;  ///< of v [unit^2]
  double count = 0.0;
  double reach = 0.0;  ///< of the last row since the segment's start [s]

  void add(const UnitSums& other);
};

/// Squares and counts of judged errors by dataset and channel.
struct Errors {
  std::vector<Vector> squares, counts;  ///< a dataset each, a channel each [noise floors^2]
  /// A horizon each, then a dataset each, then a channel each.
  std::vector<std::vector<std::vector<UnitSums>>> units;
  double log_density = 0.0;  ///< of all judged rows together, less what no model changes
  /// A dataset each, a channel each: a position or a rate, not what the drives read.
  std::vector<std::vector<bool>> of_motion;

  explicit Errors(const Problem& problem);
  void add(const Errors& other);
  /// Root of the mean over channels of their mean squares [noise floors]: channels of the motion,
  /// where any was judged. A bus voltage good to 2 mV would else be the whole gap.
  [[nodiscard]] double overall() const;
};

/// One dataset's held-out segments, to be judged.
struct Judge {
  const ObservedDataset& observed;
  const DatasetNoise& noise;
  const DatasetWhitening& whitening;  ///< of all rows
  const Settings& settings;
  double trained = 1.0;  ///< segments that the fold was fitted to
  /// Slopes as S^(1/2) has them, raw rows of the dataset x tolerances; null: nothing is open.
  const Matrix* open = nullptr;

  /// Adds the errors of a segment. `residual`: measured less predicted, all rows of the dataset.
  void judge(int dataset, int segment, const Vector& residual, Errors& errors) const;

 private:
  /// A segment after its nuisances were estimated from some of its rows.
  struct Estimated {
    Vector left;      ///< y - f - A n [unit]
    Vector variance;  ///< v [unit^2]
    Matrix root;      ///< L of I + (W A S)^T (W A S) over the prefix
    Matrix open;      ///< B S^(1/2) of the rows [unit]; no column: nothing is open
  };
  [[nodiscard]] Estimated estimated(int segment, int block, const Vector& about_mean,
                                    const Vector& prefix) const;
  void add_units(int dataset, int segment, const Estimated& at, const Vector& judged,
                 std::vector<std::vector<UnitSums>>& units) const;
};

}  // namespace jaculus::diagnosis
