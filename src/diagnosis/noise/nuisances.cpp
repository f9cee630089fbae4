#include "diagnosis/noise/nuisances.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

namespace jaculus::diagnosis {
namespace {

double shift_scale(const Alignment& alignment, int stream, const Settings& settings) {
  double mean = 0.0, squares = 0.0;
  const auto n = static_cast<double>(alignment.segments.size());
  for (const SegmentAlignment& segment : alignment.segments) mean += segment.shift[stream] / n;
  for (const SegmentAlignment& segment : alignment.segments)
    squares += std::pow(segment.shift[stream] - mean, 2);

  const double prior = settings.shift_prior_segments;
  const double prior_square = settings.shift_deviation * settings.shift_deviation;
  return std::sqrt((prior * prior_square + squares) / (prior + n - 1.0));
}

/// Adds a column of the segment's rows, unless it is zero.
void add_column(const std::string& name, double mean, double scale, const Vector& column,
                SegmentNuisances& out) {
  if (column.size() == 0 || column.cwiseAbs().maxCoeff() == 0.0) return;

  const Eigen::Index k = out.columns.cols();
  out.columns.conservativeResize(out.count, k + 1);
  out.columns.col(k) = column;
  out.mean.conservativeResize(k + 1);
  out.scale.conservativeResize(k + 1);
  out.mean[k] = mean;
  out.scale[k] = scale;
  out.names.push_back(name);
}

/// A column that is `value(channel, time)` on the rows of the segment.
template <class Value>
Vector column_of(const ObservedDataset& observed, int segment, const SegmentNuisances& rows,
                 Value&& value) {
  Vector column = Vector::Zero(rows.count);
  for (const RowSpan& span : row_spans(observed)) {
    if (span.segment != segment) continue;
    const Vector& time = observed.segments[segment].time[span.channel];
    for (int i = 0; i < span.count; ++i)
      column[span.first - rows.first + i] = value(span.channel, time[i]);
  }
  return column;
}

void add_shifts(const ObservedDataset& observed, const Alignment& alignment, int index,
                const Prediction& prediction, const Settings& settings, SegmentNuisances& out) {
  if (observed.measured_input) return;
  const Segment& segment = observed.segments[index];
  const double period = 1.0 / observed.dataset.controller.rate_hz;

  for (int s = 0; s < count_of(observed.streams); ++s) {
    const double shift = alignment.segments[index].shift[s];
    const auto slope = [&](int channel, double time) {
      if (observed.stream_of(channel) != s) return 0.0;
      return -prediction.row_slope(segment, channel, time - segment.start - shift);
    };
    const auto slope_of_hold = [&](int channel, double time) {
      return observed.channels[channel].zero_order_hold ? slope(channel, time) : 0.0;
    };

    add_column("shift of " + observed.streams[s], -shift, shift_scale(alignment, s, settings),
               column_of(observed, index, out, slope), out);
    // Where between two steps of the loop its samples lie, nobody says.
    if (std::isfinite(period) && period > 0.0)
      add_column("phase of the loop in " + observed.streams[s], 0.0, period / std::sqrt(12.0),
                 column_of(observed, index, out, slope_of_hold), out);
  }
}

void add_offsets(const ObservedDataset& observed, int segment, const Settings& settings,
                 SegmentNuisances& out) {
  for (int c = 0; c < count_of(observed.channels); ++c) {
    const double scale = offset_scale(observed, observed.channels[c], settings);
    if (scale == 0.0) continue;
    const auto own = [c](int channel, double) { return channel == c ? 1.0 : 0.0; };
    add_column("offset of " + observed.channels[c].name, 0.0, scale,
               column_of(observed, segment, out, own), out);
  }
}

}  // namespace

std::string start_nuisance(const FreeParameter& start) { return "start of " + start.name; }

bool relative_to_rest(const ObservedDataset& observed, const Channel& channel) {
  return !observed.measured_input && (channel.name == "x" || channel.name == "pitch");
}

double offset_scale(const ObservedDataset& observed, const Channel& channel,
                    const Settings& settings) {
  if (observed.measured_input) return 0.0;
  if (relative_to_rest(observed, channel)) return settings.free_offset;
  if (channel.name == "z") return settings.height_offset;
  if (channel.name == "imu_pitch") return settings.imu_offset;
  return channel.name == "bus_voltage" ? settings.bus_offset : 0.0;
}

SegmentNuisances segment_nuisances(const Problem& problem, const Alignment& alignment,
                                   const Prediction& prediction, const StartSlopes& starts,
                                   int dataset, int segment) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  SegmentNuisances out;
  for (const RowSpan& span : row_spans(observed)) {
    if (span.segment < segment) out.first = span.first + span.count;
    if (span.segment == segment) out.count += span.count;
  }
  out.columns.resize(out.count, 0);

  add_shifts(observed, alignment, segment, prediction, problem.settings, out);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    if (starts[k].empty()) continue;
    const FreeParameter& start = problem.hypotheses.parameters[problem.hypotheses.starts[k]];
    add_column(start_nuisance(start), 0.0, start.scale,
               starts[k][dataset].segment(out.first, out.count), out);
  }
  add_offsets(observed, segment, problem.settings, out);

  return out;
}

SegmentNuisances with_variability(SegmentNuisances nuisances, const ObservedDataset& observed,
                                  int segment, const std::vector<double>& variability, int modes) {
  for (const RowSpan& span : row_spans(observed)) {
    const Channel& channel = observed.channels[span.channel];
    if (span.segment != segment || variability[span.channel] == 0.0) continue;

    const Eigen::Index first = nuisances.columns.cols(), all = first + modes;
    nuisances.columns.conservativeResize(nuisances.count, all);
    nuisances.columns.rightCols(modes).setZero();
    nuisances.columns.block(span.first - nuisances.first, first, span.count, modes) =
        fault_modes(observed, channel, observed.segments[segment].time[span.channel], modes);

    nuisances.mean.conservativeResize(all);
    nuisances.mean.tail(modes).setZero();
    nuisances.scale.conservativeResize(all);
    nuisances.scale.tail(modes).setConstant(variability[span.channel]);
    nuisances.names.insert(nuisances.names.end(), modes, "variability of " + channel.name);
  }
  return nuisances;
}

Matrix fault_modes(const Vector& time, double duration, bool zero_order_hold, int modes) {
  Matrix values(time.size(), modes);
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    const double share = std::max(0.0, time[i]) / std::max(1e-9, duration);
    for (int k = 0; k < modes; ++k) {
      const double sine = std::numbers::sqrt2 * std::sin((k + 0.5) * std::numbers::pi * share);
      const double cosine =
          k == 0 ? 1.0 : std::numbers::sqrt2 * std::cos(k * std::numbers::pi * share);
      values(i, k) = zero_order_hold ? cosine : sine;
    }
    if (zero_order_hold && time[i] < 0.0) values.row(i).setZero();
  }
  return values;
}

Matrix fault_modes(const ObservedDataset& observed, const Channel& channel, const Vector& time,
                   int modes) {
  return fault_modes(time, observed.window_end, channel.zero_order_hold, modes);
}

NuisanceEstimate estimate_nuisances(const SegmentNuisances& nuisances, const Matrix& white_columns,
                                    const Vector& white_residual) {
  const Eigen::Index k = white_columns.cols();
  const Matrix H = white_columns.transpose() * white_columns + Matrix::Identity(k, k);
  const Eigen::LLT<Matrix> factor(H);
  const Vector u = factor.solve(white_columns.transpose() * white_residual);
  return {nuisances.scale.cwiseProduct(u), factor.matrixL()};
}

NuisanceEstimate estimate_by_weights(const SegmentNuisances& nuisances, const Vector& residual,
                                     const Vector& weight) {
  const Matrix white = weight.asDiagonal() * nuisances.columns * nuisances.scale.asDiagonal();
  return estimate_nuisances(nuisances, white, weight.cwiseProduct(residual));
}

Vector prefix_rows(const ObservedDataset& observed, const SegmentNuisances& nuisances,
                   int segment) {
  const Segment& own = observed.segments[segment];
  Vector prefix = Vector::Zero(nuisances.count);
  for (const RowSpan& span : row_spans(observed)) {
    if (span.segment != segment) continue;
    for (int i = 0; i < span.count; ++i)
      if (own.time[span.channel][i] < own.prefix_end)
        prefix[span.first - nuisances.first + i] = 1.0;
  }
  return prefix;
}

}  // namespace jaculus::diagnosis
