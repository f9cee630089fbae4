#pragma once
// What is diagnosed: data, hypotheses and the map from parameters to predictions. A constant value.

#include <functional>
#include <string>
#include <vector>

#include "diagnosis/forward/hypotheses.h"
#include "diagnosis/forward/prediction.h"

namespace jaculus::diagnosis {

struct Problem;
/// Whether a logged input drives every dataset: errors start anew with each window, so that slopes
/// at the nominal model hold; under a plan they grow over the whole motion.
bool in_windows(const Problem& problem);

/// D of a candidate at p (tolerance_part.h), its parameters x all tolerances.
using TolerancePart = std::function<Matrix(int candidate, const Vector& p)>;

struct Problem {
  Observations observations;
  Hypotheses hypotheses;
  ForwardModel forward;
  Settings settings{};
  TolerancePart tolerance_part{};  ///< null for models that are no plant
};

/// Predictions of all datasets at one point; segments that share a simulation share an entry.
struct PredictionSet {
  std::vector<std::vector<Prediction>> simulations;  ///< a dataset, a distinct simulation
  bool valid = false;
  std::string message;

  /// A pointer a segment.
  [[nodiscard]] std::vector<const Prediction*> segments(const ObservedDataset& observed,
                                                        int dataset) const;
};
PredictionSet predict_all(const Problem& problem, const Vector& p);

/// Rows of all datasets, one vector each.
std::vector<Vector> rows_of(const Problem& problem, const std::vector<Alignment>& alignments,
                            const PredictionSet& predictions);

}  // namespace jaculus::diagnosis
