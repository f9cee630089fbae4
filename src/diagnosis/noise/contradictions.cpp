#include "diagnosis/noise/contradictions.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

namespace jaculus::diagnosis {
namespace {

struct Pair {
  double yy = 0.0, ff = 0.0, yf = 0.0, misfit = 0.0, inverted = 0.0;
};

/// Sums over the spans of one channel, means removed.
Pair sums(const ObservedDataset& observed, const Alignment& alignment, int channel,
          const Vector& predicted) {
  Pair sum;
  for (const RowSpan& span : row_spans(observed)) {
    if (span.channel != channel) continue;
    Vector y = alignment.segments[span.segment].value[channel],
           f = predicted.segment(span.first, span.count);
    y.array() -= y.mean();
    f.array() -= f.mean();
    sum.yy += y.squaredNorm();
    sum.ff += f.squaredNorm();
    sum.yf += y.dot(f);
    sum.misfit += (y - f).squaredNorm();
    sum.inverted += (y + f).squaredNorm();
  }
  return sum;
}

std::string contradiction(const Channel& channel, double noise_floor, const Pair& sum, int rows,
                          const Settings& settings) {
  const double motion = std::sqrt(std::min(sum.yy, sum.ff) / rows);
  if (sum.yy <= 0.0 || sum.ff <= 0.0) return {};

  const double correlation = sum.yf / std::sqrt(sum.yy * sum.ff), slope = sum.yf / sum.ff;
  const double ratio = std::sqrt(sum.yy / sum.ff);
  if (correlation > settings.scaled_above) {
    const std::array<std::pair<double, const char*>, 4> units = {
        {{180.0 / std::numbers::pi, "degrees in place of radians"},
         {std::numbers::pi / 180.0, "radians counted twice as degrees"},
         {1000.0, "thousandths (millimetres) in place of SI units"},
         {0.001, "thousands of the SI unit"}}};
    for (const auto& [factor, what] : units)
      if (std::abs(slope / factor - 1.0) < settings.unit_tolerance)
        return fmt::format("{} looks like {}: it is {:.3g} times the prediction", channel.name,
                           what, slope);
  }

  if (motion < settings.motion_above_noise * noise_floor) return {};
  if (correlation < settings.inverted_below && ratio > settings.inverted_least_ratio &&
      ratio < settings.inverted_most_ratio && sum.misfit > settings.inverted_gain * sum.inverted)
    return fmt::format("{} looks inverted: its correlation with the prediction is {:.2f}",
                       channel.name, correlation);
  return {};
}

/// Squares of what windows under a logged input leave of the motion [noise floors^2].
double misfit_in_windows(const Problem& problem, const NoiseModel& noise,
                         const std::vector<Vector>& predicted) {
  double sum = 0.0;
  for (int d = 0; d < count_of(problem.observations.datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    if (!observed.measured_input) continue;
    for (int c = 0; c < count_of(observed.channels); ++c) {
      if (observed.channels[c].zero_order_hold) continue;
      const double floor = noise.datasets[d].channels[c].noise_floor;
      if (floor > 0.0)
        sum += sums(observed, noise.alignments[d], c, predicted[d]).misfit / (floor * floor);
    }
  }
  return sum;
}

}  // namespace

std::optional<Observations> with_inputs_inverted(const Observations& observations) {
  Observations out = observations;
  bool any = false;
  for (ObservedDataset& observed : out.datasets) {
    if (!observed.measured_input) continue;
    const trajectory::Quantity input = observed.dataset.controller.input;
    for (trajectory::Trial& trial : observed.dataset.trials)
      for (trajectory::Stream& stream : trial.streams)
        for (std::size_t c = 0; c < stream.channels.size(); ++c) {
          if (trajectory::parse_channel(stream.channels[c]).quantity != input) continue;
          stream.values.row(static_cast<Eigen::Index>(c)) *= -1.0;
          any = true;
        }
  }
  return any ? std::optional(std::move(out)) : std::nullopt;
}

std::string inverted_inputs(const Problem& problem, const NoiseModel& noise,
                            const Problem& inverted) {
  const PredictionSet other = predict_all(inverted, inverted.hypotheses.nominal());
  if (!other.valid) return {};
  const double as_logged = misfit_in_windows(problem, noise, rows_of(problem, noise, noise.at_p));
  const double by_inverted = misfit_in_windows(problem, noise, rows_of(problem, noise, other));
  if (!(as_logged > problem.settings.inverted_gain * by_inverted)) return {};
  return fmt::format(
      "what drives the model looks inverted: with the other sign of it the motion is {:.2g} times "
      "nearer to the prediction",
      std::sqrt(as_logged / by_inverted));
}

std::vector<std::string> contradictions(const Problem& problem, const NoiseModel& noise) {
  std::vector<std::string> found;
  const std::vector<Vector> predicted = rows_of(problem, noise, noise.at_p);
  for (int d = 0; d < count_of(problem.observations.datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    for (int c = 0; c < count_of(observed.channels); ++c) {
      Eigen::Index rows = 0;
      for (const Segment& segment : observed.segments) rows += segment.time[c].size();
      const Pair pair = sums(observed, noise.alignments[d], c, predicted[d]);
      const std::string what =
          contradiction(observed.channels[c], noise.datasets[d].channels[c].noise_floor, pair,
                        static_cast<int>(std::max<Eigen::Index>(1, rows)), problem.settings);
      if (!what.empty()) found.push_back(observed.name() + ": " + what);
    }
  }
  return found;
}

}  // namespace jaculus::diagnosis
