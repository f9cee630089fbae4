#include "diagnosis/noise/channel_noise.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace jaculus::diagnosis {
namespace {

/// Of the largest pivot, below which a column tells nothing.
constexpr double kLeastTellingPivot = 1e-8;

using Predictions = std::vector<const Prediction*>;

/// Spans of one channel up to the first impact, after which scatter says more of times than of
/// noise;
/// whole where less than one in settings.quiet_one_in, or `least` rows, come before it.
std::vector<RowSpan> quiet_spans(const ObservedDataset& observed, int channel,
                                 const Predictions& predictions, const Alignment& alignment,
                                 int least, const Settings& settings) {
  std::vector<RowSpan> spans;
  for (RowSpan span : row_spans(observed)) {
    if (span.channel != channel) continue;
    const std::vector<double>& impacts = predictions[span.segment]->impacts;

    int before = span.count;
    if (!impacts.empty()) {
      const double first = *std::min_element(impacts.begin(), impacts.end());
      const double end =
          first - settings.before_impact + alignment.origin(observed, span.segment, channel);
      const Vector& time = observed.segments[span.segment].time[channel];
      const auto found = std::lower_bound(time.begin(), time.begin() + span.count, end);
      before = static_cast<int>(found - time.begin());
    }
    if (before >= std::max(least, span.count / settings.quiet_one_in)) span.count = before;
    spans.push_back(span);
  }
  return spans;
}

/// Linear hat functions at some times, times x count, on an even grid of [from, to].
Matrix hat_basis(const Vector& time, double from, double to, int count) {
  Matrix basis = Matrix::Zero(time.size(), count);
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    const double place = (time[i] - from) / std::max(1e-12, to - from) * (count - 1);
    const int left = std::clamp(static_cast<int>(std::floor(place)), 0, count - 2);
    basis(i, left) = 1.0 - (place - left);
    basis(i, left + 1) = place - left;
  }
  return basis;
}

/// Hat functions for so many samples: two at least, which span a line.
int hat_count(int samples, int rows_each, int most) {
  return std::max(2, std::min(samples / rows_each, most));
}

/// What a fit leaves of some rows.
struct Scatter {
  std::vector<Vector> rows;  ///< a span each
  double rank = 0.0;         ///< of what was fitted
};

Vector least_squares_residual(const Matrix& columns, const Vector& residual, double& rank) {
  Eigen::ColPivHouseholderQR<Matrix> qr(columns);
  qr.setThreshold(kLeastTellingPivot);
  rank += static_cast<double>(qr.rank());
  return residual - columns * qr.solve(residual);
}

Vector times_of(const ObservedDataset& observed, const RowSpan& span) {
  return observed.segments[span.segment].time[span.channel].head(span.count);
}

/// What all segments share, a hat basis over the dataset's window, and each segment's nuisances
/// taken out.
Scatter about_common_motion(const ObservedDataset& observed, const std::vector<RowSpan>& spans,
                            const Vector& residual, const std::vector<SegmentNuisances>& nuisances,
                            const Settings& settings) {
  int rows = 0;
  for (const RowSpan& span : spans) rows += span.count;
  const bool several = spans.size() > 1;
  const int samples = rows / count_of(spans);
  const int hats =
      several ? hat_count(samples, settings.rows_of_hat, settings.hat_functions)
              : hat_count(samples, settings.rows_of_hat_alone, settings.hat_functions_alone);
  Eigen::Index width = hats;
  for (const RowSpan& span : spans)
    if (several) width += nuisances[span.segment].columns.cols();

  Matrix columns = Matrix::Zero(rows, width);
  Vector stacked(rows);
  Eigen::Index row = 0, column = hats;
  for (const RowSpan& span : spans) {
    stacked.segment(row, span.count) = residual.segment(span.first, span.count);
    columns.block(row, 0, span.count, hats) =
        hat_basis(times_of(observed, span), observed.window_start, observed.window_end, hats);
    if (several) {
      const SegmentNuisances& own = nuisances[span.segment];
      columns.block(row, column, span.count, own.columns.cols()) =
          own.columns.middleRows(span.first - own.first, span.count) * own.scale.asDiagonal();
      column += own.columns.cols();
    }
    row += span.count;
  }

  Scatter scatter;
  const Vector left = least_squares_residual(columns, stacked, scatter.rank);
  row = 0;
  for (const RowSpan& span : spans) {
    scatter.rows.push_back(left.segment(row, span.count));
    row += span.count;
  }
  return scatter;
}

/// Each segment's own motion, a hat basis over its own time, taken out: windows of a logged input
/// share nothing.
Scatter about_own_motion(const ObservedDataset& observed, const std::vector<RowSpan>& spans,
                         const Vector& residual, const Settings& settings) {
  int rows = 0;
  for (const RowSpan& span : spans) rows += span.count;
  const int samples = rows / count_of(spans);
  const int hats = hat_count(samples, settings.rows_of_hat_alone, settings.hat_functions_alone);

  Scatter scatter;
  for (const RowSpan& span : spans) {
    const Vector time = times_of(observed, span);
    const Matrix basis = hat_basis(time, time[0], time[time.size() - 1], hats);
    scatter.rows.push_back(
        least_squares_residual(basis, residual.segment(span.first, span.count), scatter.rank));
  }
  return scatter;
}

void set_scatter(const Scatter& scatter, const Settings& settings, ChannelNoise& channel) {
  double rows = 0.0, products = 0.0, squares = 0.0;
  for (const Vector& own : scatter.rows) {
    const Eigen::Index pairs = own.size() - 1;
    products += own.head(pairs).dot(own.tail(pairs));
    squares += own.squaredNorm();
    rows += static_cast<double>(own.size());
  }

  const double freedom = rows - scatter.rank;
  channel.noise_floor = freedom > 0.0 ? std::sqrt(squares / freedom) : 0.0;
  const double lag_one = squares > 0.0 ? products / squares + scatter.rank / rows : 0.0;
  channel.correlation = std::clamp(lag_one, 0.0, settings.largest_correlation);
}

/// Rows less what all nuisances of each segment, estimated together, make of them.
Vector without_nuisances(const ObservedDataset& observed, Vector residual,
                         const std::vector<SegmentNuisances>& nuisances,
                         const std::vector<ChannelNoise>& channels) {
  Vector weight(residual.size());
  for (const RowSpan& span : row_spans(observed)) {
    const double floor = channels[span.channel].noise_floor;
    weight.segment(span.first, span.count).setConstant(floor > 0.0 ? 1.0 / floor : 0.0);
  }

  for (const SegmentNuisances& own : nuisances) {
    if (own.count == 0 || own.columns.cols() == 0) continue;
    const Vector r = residual.segment(own.first, own.count) - own.columns * own.mean;
    const Vector deviation =
        estimate_by_weights(own, r, weight.segment(own.first, own.count)).deviation;
    residual.segment(own.first, own.count) -= own.columns * (own.mean + deviation);
  }
  return residual;
}

/// Deviation of each smooth mode of a segment's own (a foot slips in one and not in the next): what
/// segments do beyond noise and starts, less what they share; 0 where noise alone would do it
/// [unit].
double variability(const ObservedDataset& observed, const std::vector<RowSpan>& spans,
                   const Vector& residual, const ChannelNoise& noise, const Settings& settings) {
  const auto segments = static_cast<double>(spans.size());
  if (segments < 2.0 || noise.noise_floor == 0.0) return 0.0;

  const int count = settings.variability_modes;
  const Channel& channel = observed.channels[spans.front().channel];
  std::vector<Vector> found;
  Vector mean = Vector::Zero(count);
  double rows = 0.0;
  for (const RowSpan& span : spans) {
    const Matrix modes = fault_modes(observed, channel, times_of(observed, span), count);
    const Matrix ridge = settings.mode_ridge * span.count * Matrix::Identity(count, count);
    const Matrix H = modes.transpose() * modes + ridge;
    found.push_back(H.ldlt().solve(modes.transpose() * residual.segment(span.first, span.count)));
    mean += found.back() / segments;
    rows += span.count;
  }

  double square = 0.0;  // of a mode in a segment
  for (const Vector& own : found) square += (own - mean).squaredNorm() / (segments - 1.0) / count;
  const double by_noise = std::pow(noise.noise_floor, 2) * noise.inflation() / (rows / segments);
  return square > settings.variability_from * by_noise ? std::sqrt(square - by_noise) : 0.0;
}

}  // namespace

std::vector<ChannelNoise> channel_noise(const ObservedDataset& observed,
                                        const Predictions& predictions, const Alignment& alignment,
                                        const std::vector<SegmentNuisances>& nuisances,
                                        const Settings& settings) {
  const Vector residual =
      measured_rows(observed, alignment) - predicted_rows(observed, alignment, predictions);
  Eigen::Index most = 0;
  for (const SegmentNuisances& own : nuisances) most = std::max(most, own.columns.cols());
  const int least = 2 * static_cast<int>(most);

  std::vector<ChannelNoise> channels(observed.channels.size());
  for (int c = 0; c < count_of(channels); ++c) {
    const auto spans = quiet_spans(observed, c, predictions, alignment, least, settings);
    if (spans.empty()) continue;
    const Scatter scatter =
        observed.measured_input
            ? about_own_motion(observed, spans, residual, settings)
            : about_common_motion(observed, spans, residual, nuisances, settings);
    set_scatter(scatter, settings, channels[c]);
  }
  if (observed.measured_input) return channels;

  const Vector left = without_nuisances(observed, residual, nuisances, channels);
  for (int c = 0; c < count_of(channels); ++c) {
    const auto spans = quiet_spans(observed, c, predictions, alignment, 0, settings);
    if (!spans.empty())
      channels[c].variability = variability(observed, spans, left, channels[c], settings);
  }
  return channels;
}

}  // namespace jaculus::diagnosis
