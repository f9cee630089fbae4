#include "diagnosis/noise/one_off.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "diagnosis/data/scatter.h"

namespace jaculus::diagnosis {
namespace {

/// Bin of a time among `count` over the dataset's window.
int bin_of(const ObservedDataset& observed, double time, int count) {
  const double share =
      (time - observed.window_start) / (observed.window_end - observed.window_start);
  return std::clamp(static_cast<int>(share * count), 0, count - 1);
}

/// The median of those that are numbers, NaN without any.
double median_of_known(const Vector& values) {
  std::vector<double> known;
  for (const double value : values)
    if (std::isfinite(value)) known.push_back(value);
  return known.empty() ? kNaN : median(std::move(known));
}

/// Mean of every segment's residual by bin of time, less the median over segments, segments x bins;
/// NaN where a segment has no row.
Matrix scatter_by_bin(const ObservedDataset& observed, int channel, const Vector& residual,
                      int bins) {
  Matrix sums = Matrix::Zero(count_of(observed.segments), bins), counts = sums;
  for (const RowSpan& span : row_spans(observed)) {
    if (span.channel != channel) continue;
    const Vector& time = observed.segments[span.segment].time[channel];
    for (int i = 0; i < span.count; ++i) {
      const int bin = bin_of(observed, time[i], bins);
      sums(span.segment, bin) += residual[span.first + i];
      counts(span.segment, bin) += 1.0;
    }
  }

  Matrix means = (counts.array() > 0.0).select(sums.array() / counts.array().max(1.0), kNaN);
  for (Eigen::Index b = 0; b < bins; ++b) means.col(b).array() -= median_of_known(means.col(b));
  return means;
}

/// Mean over segments of the residual at the rows of every segment, by nearest of some fine bins.
Vector mean_over_segments(const ObservedDataset& observed, const Vector& residual, int bins) {
  const Eigen::Index channels = count_of(observed.channels);
  Matrix sums = Matrix::Zero(channels, bins), counts = sums;
  const auto each_row = [&](auto&& visit) {
    for (const RowSpan& span : row_spans(observed)) {
      const Vector& time = observed.segments[span.segment].time[span.channel];
      for (int i = 0; i < span.count; ++i)
        visit(span.channel, bin_of(observed, time[i], bins), span.first + i);
    }
  };

  each_row([&](int channel, int bin, int row) {
    sums(channel, bin) += residual[row];
    counts(channel, bin) += 1.0;
  });
  Vector mean = residual;
  each_row([&](int channel, int bin, int row) {
    mean[row] = sums(channel, bin) / counts(channel, bin);
  });
  return mean;
}

/// Residuals with every segment's own nuisances, as the first half of the window tells them, taken
/// away: a start or a shift is no disturbance, and one in the second half doesn't pass for a shift.
Vector without_nuisances(const ObservedDataset& observed, const DatasetNoise& noise,
                         const Vector& residual, const Vector& mean) {
  const double half = 0.5 * (observed.window_start + observed.window_end);
  Vector weight(residual.size());
  for (const RowSpan& span : row_spans(observed)) {
    const Vector& time = observed.segments[span.segment].time[span.channel];
    const double one = 1.0 / std::max(1e-12, noise.channels[span.channel].noise_floor);
    for (int i = 0; i < span.count; ++i) weight[span.first + i] = time[i] < half ? one : 0.0;
  }

  Vector out = residual;
  for (const SegmentNuisances& own : noise.nuisances) {
    if (own.count == 0 || own.columns.cols() == 0) continue;
    const Vector about_mean =
        residual.segment(own.first, own.count) - mean.segment(own.first, own.count);
    out.segment(own.first, own.count) -=
        own.columns *
        estimate_by_weights(own, about_mean, weight.segment(own.first, own.count)).deviation;
  }
  return out;
}

/// The earliest bin from which a segment is loud to the end while it was quiet before; bins where
/// there is none.
int onset_bin(const Eigen::RowVectorXd& own, const Eigen::RowVectorXd& usual,
              const Settings& settings) {
  const int bins = settings.one_off_bins;
  const double quiet = settings.one_off_quiet * settings.one_off_quiet;
  int loud = bins;
  while (loud > 0 && own[loud - 1] > settings.one_off_excess * usual[loud - 1]) --loud;
  if (loud == bins || loud < settings.one_off_fewest_bins) return bins;
  for (int b = 0; b + 1 < loud; ++b)
    if (own[b] > quiet * usual[b]) return bins;
  return loud;
}

/// Largest scatter of the other segments, by bin, and a floor [unit^2]; NaN where too few others
/// have rows to say what is usual.
Eigen::RowVectorXd usual_scatter(const Matrix& squares, Eigen::Index segment, double floor,
                                 int fewest) {
  Eigen::RowVectorXd usual = Eigen::RowVectorXd::Zero(squares.cols());
  for (Eigen::Index b = 0; b < squares.cols(); ++b) {
    int others = 0;
    for (Eigen::Index other = 0; other < squares.rows(); ++other) {
      if (other == segment || !std::isfinite(squares(other, b))) continue;
      usual[b] = std::max(usual[b], squares(other, b));
      ++others;
    }
    usual[b] = others < fewest ? kNaN : usual[b] + floor;
  }
  return usual;
}

std::vector<OneOff> find_one_offs(const Problem& problem, const NoiseModel& noise, int dataset,
                                  const std::vector<ChannelPlace>& ignored) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  const DatasetNoise& own_noise = noise.datasets[dataset];
  const int segments = count_of(observed.segments);
  if (observed.measured_input || segments < problem.settings.one_off_fewest) return {};

  const Alignment& alignment = noise.alignments[dataset];
  const Vector raw = measured_rows(observed, alignment) -
                     predicted_rows(observed, alignment, noise.at_p.segments(observed, dataset));
  const Vector mean = mean_over_segments(observed, raw, problem.settings.one_off_fine_bins);
  const Vector residual = without_nuisances(observed, own_noise, raw, mean);
  const int bins = problem.settings.one_off_bins;
  const double bin_length = (observed.window_end - observed.window_start) / bins;
  std::vector<OneOff> best(segments);
  for (int c = 0; c < count_of(observed.channels); ++c) {
    const bool left_out = std::any_of(ignored.begin(), ignored.end(), [&](const ChannelPlace& p) {
      return p.dataset == dataset && p.channel == c;
    });
    if (left_out || observed.channels[c].zero_order_hold) continue;
    const Matrix squares = scatter_by_bin(observed, c, residual, bins).array().square();
    const double floor =
        problem.settings.one_off_floor * std::pow(own_noise.channels[c].noise_floor, 2);
    for (int s = 0; s < segments; ++s) {
      const Eigen::RowVectorXd usual =
          usual_scatter(squares, s, floor, problem.settings.one_off_fewest - 1);
      const int bin = onset_bin(squares.row(s), usual, problem.settings);
      const int after = bins - bin;
      if (after < problem.settings.one_off_fewest_bins) continue;
      const double excess = std::sqrt(squares.row(s).tail(after).mean() / usual.tail(after).mean());
      if (excess <= best[s].excess) continue;
      best[s] = {dataset,
                 s,
                 observed.dataset.trials[observed.segments[s].trial].name,
                 observed.window_start + (bin - 1) * bin_length,
                 excess,
                 observed.channels[c].name};
    }
  }

  std::erase_if(best, [](const OneOff& own) { return own.excess <= 0.0; });
  return best;
}

}  // namespace

std::vector<OneOff> one_off_disturbances(const Problem& problem, const NoiseModel& noise,
                                         const std::vector<ChannelPlace>& ignored) {
  std::vector<OneOff> found;
  for (int d = 0; d < count_of(problem.observations.datasets); ++d) {
    const std::vector<OneOff> own = find_one_offs(problem, noise, d, ignored);
    // Where half of the segments differ from one another it is no one-off.
    if (own.size() * 2 < problem.observations.datasets[d].segments.size())
      found.insert(found.end(), own.begin(), own.end());
  }
  return found;
}

}  // namespace jaculus::diagnosis
