#include "diagnosis/noise/alignment.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/nuisances.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kLeastMisfit = 1e-12;  // of a row [unit], that divides

/// Mean of a span's residual before the command, where the robot rests; 0 without such rows.
double rest_of(const Vector& residual, const Vector& time, double command) {
  double sum = 0.0;
  Eigen::Index count = 0;
  for (; count < residual.size() && time[count] < command; ++count) sum += residual[count];
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

/// Residual of a span and minus its slope in time, both less their means where the channel is
/// relative to rest. Other channels with an unknown zero begin at rest: a tracked point that sits
/// 10 mm lower than stated is no clock that is 10 ms late.
struct SpanSystem {
  Vector residual, slope;
};

SpanSystem span_system(const ObservedDataset& observed, const RowSpan& span,
                       const Prediction& prediction, double shift, const Settings& settings) {
  const Segment& segment = observed.segments[span.segment];
  const Vector& time = segment.time[span.channel];
  const double h = prediction.step;
  SpanSystem system{Vector(span.count), Vector(span.count)};

  for (int i = 0; i < span.count; ++i) {
    const double t = time[i] - segment.start - shift;
    const double after = prediction.at(span.channel, t + h),
                 before = prediction.at(span.channel, t - h);
    system.residual[i] = segment.value[span.channel][i] - prediction.row(segment, span.channel, t);
    system.slope[i] = -(after - before) / (2.0 * h);
  }

  const Channel& channel = observed.channels[span.channel];
  if (relative_to_rest(observed, channel)) {
    system.residual.array() -= system.residual.mean();
    system.slope.array() -= system.slope.mean();
  } else if (offset_scale(observed, channel, settings) > 0.0) {
    system.residual.array() -= rest_of(system.residual, time, segment.start + shift);
  }
  return system;
}

/// One stream of one segment, whose shift is sought.
struct ShiftSearch {
  const ObservedDataset& observed;
  const Prediction& prediction;
  const Settings& settings;
  double deviation = 0.0;  ///< prior, of the shift [s]
  std::vector<RowSpan> spans;

  struct Point {
    double shift = 0.0;  ///< [s]
    double cost = 0.0;   ///< twice the negative log of the posterior
    double step = 0.0;   ///< of Gauss-Newton from here [s]
  };

  [[nodiscard]] Point at(double shift) const {
    const double prior = 1.0 / (deviation * deviation);
    double cost = prior * shift * shift;
    double gradient = -shift * prior, curvature = prior;

    for (const RowSpan& span : spans) {
      const SpanSystem system = span_system(observed, span, prediction, shift, settings);
      const double least = span.count * kLeastMisfit * kLeastMisfit;
      const double squares = std::max(least, system.residual.squaredNorm());
      const double told = std::min(settings.discrepancy_modes, span.count);
      cost += told * std::log(squares);
      gradient += told / squares * system.slope.dot(system.residual);
      curvature += told / squares * system.slope.squaredNorm();
    }

    return {shift, cost, gradient / curvature};
  }

  [[nodiscard]] double best(double from) const {
    const double most = settings.largest_shift;
    Point here = at(from);
    for (int i = 0;
         i < settings.alignment_steps && std::abs(here.step) > settings.alignment_converged; ++i) {
      const Point next = at(std::clamp(here.shift + here.step, -most, most));
      if (next.cost >= here.cost)
        here.step *= settings.alignment_shortened;
      else
        here = next;
    }
    return here.shift;
  }
};

/// The rows by which a span is aligned: all, or those of the prefix where the prediction jumps, if
/// it has any to speak of. Rows between a jump and where it was predicted would pull the clock by
/// milliseconds, each segment's its own way.
RowSpan aligned_part(const ObservedDataset& observed, RowSpan span, const Prediction& prediction,
                     const Settings& settings) {
  if (prediction.impacts.empty()) return span;

  const Segment& segment = observed.segments[span.segment];
  const Vector& time = segment.time[span.channel];
  const auto end = std::lower_bound(time.begin(), time.begin() + span.count, segment.prefix_end);
  const int before = static_cast<int>(end - time.begin());
  if (before >= settings.least_aligned) span.count = before;
  return span;
}

}  // namespace

Alignment align(const ObservedDataset& observed, const std::vector<const Prediction*>& predictions,
                const Alignment& from, const Settings& settings) {
  Alignment alignment = unaligned(observed);
  for (int s = 0; s < count_of(observed.segments); ++s)
    alignment.segments[s].shift = from.segments[s].shift;
  if (observed.measured_input) return alignment;

  for (int c = 0; c < count_of(observed.channels); ++c)
    alignment.late[c] = predictions.front()->lateness(c);
  const double deviation =
      tracked_alone(observed) ? settings.foreign_clock : settings.shift_deviation;
  const std::vector<RowSpan> all = row_spans(observed);
  for (int r = 0; r < count_of(observed.segments); ++r) {
    for (int s = 0; s < count_of(observed.streams); ++s) {
      ShiftSearch search{observed, *predictions[r], settings, deviation, {}};
      for (const RowSpan& span : all) {
        const bool own = span.segment == r && observed.stream_of(span.channel) == s;
        if (own && !observed.channels[span.channel].zero_order_hold)
          search.spans.push_back(aligned_part(observed, span, *predictions[r], settings));
      }
      double& shift = alignment.segments[r].shift[s];
      if (!search.spans.empty()) shift = search.best(shift);
    }
  }

  return alignment;
}

}  // namespace jaculus::diagnosis
