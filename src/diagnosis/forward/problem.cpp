#include "diagnosis/forward/problem.h"

namespace jaculus::diagnosis {

std::vector<const Prediction*> PredictionSet::segments(const ObservedDataset& observed,
                                                       int dataset) const {
  const std::vector<Prediction>& own = simulations[dataset];
  std::vector<const Prediction*> pointers;
  for (std::size_t s = 0; s < observed.segments.size(); ++s)
    pointers.push_back(&own[own.size() == 1 ? 0 : s]);
  return pointers;
}

PredictionSet predict_all(const Problem& problem, const Vector& p) {
  PredictionSet set;
  set.valid = true;

  for (int d = 0; d < count_of(problem.observations.datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    const int count = observed.measured_input ? count_of(observed.segments) : 1;
    set.simulations.emplace_back();
    for (int s = 0; s < count; ++s) {
      set.simulations.back().push_back(problem.forward(d, s, p));
      const Prediction& prediction = set.simulations.back().back();
      if (prediction.valid) continue;
      set.valid = false;
      set.message = prediction.message;
      return set;
    }
  }

  return set;
}

std::vector<Vector> rows_of(const Problem& problem, const std::vector<Alignment>& alignments,
                            const PredictionSet& predictions) {
  std::vector<Vector> rows;
  for (int d = 0; d < count_of(problem.observations.datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    rows.push_back(predicted_rows(observed, alignments[d], predictions.segments(observed, d)));
  }
  return rows;
}

}  // namespace jaculus::diagnosis
