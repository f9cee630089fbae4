#include "diagnosis/validation/folds.h"

#include <algorithm>

namespace jaculus::diagnosis {
namespace {

/// The mask that holds out the segments of which out(dataset, segment) is true.
template <class Out>
SegmentMask mask_of(const Observations& observations, Out&& out) {
  SegmentMask mask;
  for (int d = 0; d < count_of(observations.datasets); ++d) {
    mask.emplace_back();
    for (int s = 0; s < count_of(observations.datasets[d].segments); ++s)
      mask.back().push_back(!out(d, s));
  }
  return mask;
}

/// A trial's place among those of a dataset that have segments.
int place_of(const ObservedDataset& observed, int segment) {
  std::vector<int> trials;
  for (const Segment& own : observed.segments)
    if (trials.empty() || trials.back() != own.trial) trials.push_back(own.trial);
  return index_of(trials, observed.segments[segment].trial);
}

}  // namespace

Folds folds_of(const Observations& observations, const Settings& settings) {
  const std::vector<ObservedDataset>& datasets = observations.datasets;
  int trials = 0;
  for (const ObservedDataset& observed : datasets) trials += observed.trials;

  Folds folds;
  if (datasets.size() > 1) {
    folds.over = "conditions";
    for (int d = 0; d < count_of(datasets); ++d)
      folds.masks.push_back(mask_of(observations, [d](int own, int) { return own == d; }));
  } else if (trials > 1) {
    folds.over = "trials";
    const int count = std::min(settings.most_folds, trials);
    for (int f = 0; f < count; ++f)
      folds.masks.push_back(mask_of(observations, [&](int, int segment) {
        return place_of(datasets[0], segment) % count == f;
      }));
  } else {
    folds.over = "time";
    const int count = settings.time_folds;
    const bool windows = datasets.size() == 1 && datasets[0].segments.size() > 1;
    for (int f = 0; f < count && windows; ++f)
      folds.masks.push_back(
          mask_of(observations, [&](int, int segment) { return segment % count == f; }));
  }
  return folds;
}

}  // namespace jaculus::diagnosis
