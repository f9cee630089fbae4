#include "diagnosis/localise/rows.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace jaculus::diagnosis {
namespace {

/// 1/(sigma sqrt(inflation)) of every row; 0 where a channel's noise isn't known.
Vector row_weights(const ResidualRows& rows) {
  Vector weight = Vector::Zero(rows.judged.size());
  for (const RowSpan& span : rows.spans) {
    const ChannelNoise& channel = rows.channels[span.channel];
    if (!(channel.noise_floor > 0.0)) continue;
    const double deviation = channel.noise_floor * std::sqrt(channel.inflation());
    weight.segment(span.first, span.count).setConstant(1.0 / deviation);
  }
  return weight;
}

/// Takes a segment's nuisances, as its prefix gives them, out of `judged`.
void take_nuisances(const SegmentNuisances& own, int segment, const Vector& weight,
                    ResidualRows& rows) {
  if (own.columns.cols() == 0) return;

  auto judged = rows.judged.segment(own.first, own.count);
  judged -= own.columns * own.mean;
  const Vector use =
      weight.segment(own.first, own.count).cwiseProduct(prefix_rows(rows.observed, own, segment));
  const NuisanceEstimate estimate = estimate_by_weights(own, judged, use);
  judged -= own.columns * estimate.deviation;

  const Matrix scaled = own.columns * own.scale.asDiagonal();
  const Matrix open =
      estimate.root.triangularView<Eigen::Lower>().solve(scaled.transpose()).transpose();
  rows.judged_deviation.segment(own.first, own.count) = open.rowwise().norm();
}

}  // namespace

ResidualRows residual_rows(const Problem& problem, const NoiseModel& noise, int dataset) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  const Alignment& alignment = noise.alignments[dataset];
  const DatasetNoise& own = noise.datasets[dataset];
  ResidualRows rows{dataset,
                    observed,
                    alignment,
                    own.channels,
                    row_spans(observed),
                    noise.at_p.segments(observed, dataset),
                    measured_rows(observed, alignment),
                    Vector::Zero(observed.rows())};

  rows.judged -= predicted_rows(observed, alignment, rows.predictions);
  const Vector weight = row_weights(rows);
  for (int s = 0; s < count_of(own.nuisances); ++s)
    take_nuisances(own.nuisances[s], s, weight, rows);
  return rows;
}

}  // namespace jaculus::diagnosis
