#include "diagnosis/noise/row_deviations.h"

#include <algorithm>
#include <cmath>

namespace jaculus::diagnosis {
namespace {

/// Model times between which a jump may fall: around an impact, as predicted and as this span's
/// data show it.
struct JumpWindow {
  double from = 0.0, to = 0.0;  ///< [s]
  double size = 0.0;            ///< predicted across it [unit]
};

/// A span with what its timing is judged by.
struct TimedSpan {
  const Vector& time;   ///< of its rows, the data's [s]
  const Vector& value;  ///< [unit]
  const Prediction& prediction;
  const Settings& settings;
  int channel = 0;
  double origin = 0.0;  ///< data's time of the model's zero [s]
  double reach = 0.0;   ///< by which a jump's time is uncertain [s]
};

/// Where data fall or rise by half the predicted jump or more between neighbours, the steepest
/// place within reach is taken for it; where none do (positions only bend), the jump is where it
/// was predicted.
JumpWindow jump_window(const TimedSpan& span, double impact) {
  const double size = span.prediction.at(span.channel, impact + span.reach) -
                      span.prediction.at(span.channel, impact - span.reach);
  JumpWindow window{impact - span.reach, impact + span.reach, std::abs(size)};

  double most = span.settings.jump_share * std::abs(size);
  for (Eigen::Index i = 1; i < span.time.size(); ++i) {
    const double t = 0.5 * (span.time[i - 1] + span.time[i]) - span.origin;
    const double rise = (span.value[i] - span.value[i - 1]) * (size < 0.0 ? -1.0 : 1.0);
    if (std::abs(t - impact) > span.settings.jump_sought || rise <= most) continue;
    most = rise;
    window.from = std::min(impact, t) - span.reach;
    window.to = std::max(impact, t) + span.reach;
  }

  return window;
}

/// By how much what follows the last impact before t may come sooner or later than predicted [s].
double late_impact(const Prediction& prediction, double t, const Settings& settings) {
  const auto next = std::upper_bound(prediction.impacts.begin(), prediction.impacts.end(), t);
  const double since_first = *std::prev(next) - prediction.impacts.front();
  return settings.answer_jitter + settings.rebound_share * since_first;
}

/// What timing alone may do to a row at model time t [unit].
double timing_error(const TimedSpan& span, const std::vector<JumpWindow>& windows,
                    bool zero_order_hold, double t) {
  const Prediction& prediction = span.prediction;
  const double step = prediction.step;
  const double rise = prediction.at(span.channel, t + step) - prediction.at(span.channel, t - step);
  const double slope = std::abs(rise) / (2.0 * step);

  double error = zero_order_hold ? span.settings.hold_jitter * slope : 0.0;
  if (!prediction.impacts.empty() && t > prediction.impacts.front())
    error = std::max(error, late_impact(prediction, t, span.settings) * slope);
  for (const JumpWindow& window : windows)
    if (t >= window.from && t <= window.to)
      error = std::max(error, span.settings.jump_share * window.size);
  return error;
}

}  // namespace

Vector row_deviations(const Problem& problem, const NoiseModel& noise, int dataset,
                      const RowSpan& span, const Prediction& prediction) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  const Alignment& alignment = noise.alignments[dataset];
  const Settings& settings = problem.settings;
  const Segment& segment = observed.segments[span.segment];
  const bool hold = observed.channels[span.channel].zero_order_hold;
  Vector deviation =
      Vector::Constant(span.count, noise.datasets[dataset].channels[span.channel].noise_floor);
  if (!hold && prediction.impacts.empty()) return deviation;

  const double half_block = 0.5 * (segment.block[span.channel] - 1) * segment.spacing[span.channel];
  const TimedSpan timed{segment.time[span.channel],
                        alignment.segments[span.segment].value[span.channel],
                        prediction,
                        settings,
                        span.channel,
                        alignment.origin(observed, span.segment, span.channel),
                        half_block + prediction.step + settings.jump_clock};
  std::vector<JumpWindow> windows;
  for (const double impact : prediction.impacts) windows.push_back(jump_window(timed, impact));
  for (const double step : prediction.steps)
    if (hold) windows.push_back(jump_window(timed, step));

  const bool commanded = hold && !observed.measured_input;
  for (int i = 0; i < span.count; ++i) {
    const double t = timed.time[i] - timed.origin;
    deviation[i] = std::hypot(deviation[i], timing_error(timed, windows, hold, t));
    if (commanded && t < prediction.lateness(span.channel) + settings.command_settles)
      deviation[i] *= settings.no_information;
  }
  return deviation;
}

}  // namespace jaculus::diagnosis
