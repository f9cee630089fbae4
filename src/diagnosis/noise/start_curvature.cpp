#include "diagnosis/noise/start_curvature.h"

namespace jaculus::diagnosis {
namespace {

/// Most probable nuisances of a segment by the rows of its prefix that no loop holds.
Vector by_prefix(const ObservedDataset& observed, const SegmentNuisances& nuisances, int index,
                 const Vector& residual, const std::vector<ChannelNoise>& channels) {
  Vector weight = prefix_rows(observed, nuisances, index);
  for (const RowSpan& span : row_spans(observed)) {
    if (span.segment != index) continue;
    const double floor = channels[span.channel].noise_floor;
    const bool tells = !observed.channels[span.channel].zero_order_hold && floor > 0.0;
    weight.segment(span.first - nuisances.first, span.count) *= tells ? 1.0 / floor : 0.0;
  }

  const Vector own = residual.segment(nuisances.first, nuisances.count);
  const Vector about_mean = own - nuisances.columns * nuisances.mean;
  return nuisances.mean + estimate_by_weights(nuisances, about_mean, weight).deviation;
}

/// Start offsets as found, added to p, and what they do by their slopes.
struct FoundStart {
  Vector p;
  Vector by_slopes;  ///< rows of the segment [unit]
};

FoundStart found_start(const Hypotheses& hypotheses, const SegmentNuisances& nuisances,
                       const Vector& found, const Vector& p) {
  FoundStart start{p, Vector::Zero(nuisances.count)};
  for (const int index : hypotheses.starts) {
    const std::string name = start_nuisance(hypotheses.parameters[index]);
    for (int k = 0; k < count_of(nuisances.names); ++k) {
      if (nuisances.names[k] != name) continue;
      start.p[index] += found[k];
      start.by_slopes += found[k] * nuisances.columns.col(k);
    }
  }
  return start;
}

}  // namespace

std::optional<Alignment> without_start_curvature(const Problem& problem, const Vector& p,
                                                 int dataset,
                                                 const std::vector<const Prediction*>& predictions,
                                                 const std::vector<SegmentNuisances>& nuisances,
                                                 const std::vector<ChannelNoise>& channels,
                                                 const Alignment& alignment) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  if (observed.measured_input || problem.hypotheses.starts.empty()) return {};

  const Vector straight = predicted_rows(observed, alignment, predictions);
  const Vector residual = measured_rows(observed, alignment) - straight;
  Alignment changed = alignment;
  bool any = false;
  for (int s = 0; s < count_of(observed.segments); ++s) {
    const SegmentNuisances& own = nuisances[s];
    const Vector found = by_prefix(observed, own, s, residual, channels);
    const FoundStart start = found_start(problem.hypotheses, own, found, p);
    if (start.p == p) continue;
    const Prediction there = problem.forward(dataset, s, start.p);
    if (!there.valid) continue;

    const Segment& segment = observed.segments[s];
    for (const RowSpan& span : row_spans(observed)) {
      if (span.segment != s) continue;
      const double origin = alignment.origin(observed, s, span.channel);
      for (int i = 0; i < span.count; ++i) {
        const double t = segment.time[span.channel][i] - origin;
        const double moved = there.row(segment, span.channel, t) - straight[span.first + i];
        changed.segments[s].value[span.channel][i] -=
            moved - start.by_slopes[span.first - own.first + i];
      }
    }
    any = true;
  }

  return any ? std::optional(changed) : std::nullopt;
}

}  // namespace jaculus::diagnosis
