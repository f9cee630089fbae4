#include "diagnosis/forward/problem.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>

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
  struct Place {
    int dataset, simulation;
  };
  std::vector<Place> places;
  PredictionSet set;
  for (int d = 0; d < count_of(problem.observations.datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    const int count = observed.measured_input ? count_of(observed.segments) : 1;
    set.simulations.emplace_back(count);
    for (int s = 0; s < count; ++s) places.push_back({d, s});
  }

  // Isolated: a thread that waits here must not take up a task of the caller's loop meanwhile.
  std::atomic<bool> failed = false;
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(0, count_of(places), [&](int i) {
      if (failed) return;
      Prediction& own = set.simulations[places[i].dataset][places[i].simulation];
      own = problem.forward(places[i].dataset, places[i].simulation, p);
      if (!own.valid) failed = true;
    });
  });

  set.valid = !failed;
  for (const Place& place : places)
    if (set.message.empty()) set.message = set.simulations[place.dataset][place.simulation].message;
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

bool in_windows(const Problem& problem) {
  const std::vector<ObservedDataset>& datasets = problem.observations.datasets;
  return std::all_of(datasets.begin(), datasets.end(),
                     [](const ObservedDataset& d) { return d.measured_input; });
}

}  // namespace jaculus::diagnosis
