#include "jaculus/trajectory/log_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "jaculus/trajectory/quantity.h"

namespace jaculus::trajectory {
namespace {

constexpr int kSpanSamples = 4;       // chosen
constexpr double kCorrelated = 0.95;  // [-] chosen
constexpr double kRateOff = 0.1;      // of a rate: dropped samples leave the median as it is
constexpr double kUnitWithin = 0.1;   // of a slope, where it is named

/// Sums over spans.
struct WayAndRate {
  double dd = 0.0, ii = 0.0, di = 0.0;
};

/// Spans of a position and a rate, gaps left out.
void add_spans(const Stream& stream, int position, int rate, WayAndRate& sums) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < stream.time.size(); ++k)
    if (std::isfinite(stream.values(position, k)) && std::isfinite(stream.values(rate, k)))
      kept.push_back(k);

  double integral = 0.0;
  std::size_t first = 0;
  for (std::size_t n = 1; n < kept.size(); ++n) {
    const Eigen::Index a = kept[n - 1], b = kept[n];
    integral +=
        0.5 * (stream.values(rate, a) + stream.values(rate, b)) * (stream.time[b] - stream.time[a]);
    const Eigen::Index from = kept[first];
    if (n - first < kSpanSamples || stream.time[b] - stream.time[from] < kLogSpan) continue;
    const double way = stream.values(position, b) - stream.values(position, from);
    sums.dd += way * way;
    sums.ii += integral * integral;
    sums.di += way * integral;
    integral = 0.0;
    first = n;
  }
}

/// What a factor may mean, after a comma; empty where nothing is known.
std::string meaning_of(double slope) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const std::pair<double, const char*> known[] = {
      {-1.0, ", so that one has the other sign"},
      {kDegrees, ", as degrees beside rad/s would"},
      {1.0 / kDegrees, ", as radians beside deg/s would"},
      {1000.0, ", as mm beside m/s would"},
      {0.001, ", as m beside mm/s or a time in ms would"},
      {1e-6, ", as a time in us would"},
      {std::numbers::pi / 30.0, ", as radians beside turns a minute would"}};
  for (const auto& [factor, text] : known)
    if (std::abs(slope / factor - 1.0) < kUnitWithin) return text;
  return "";
}

/// Of one trial, which is not named yet.
std::optional<RateContradiction> contradiction_in(const Stream& stream,
                                                  const std::string& channel) {
  const int rate = stream.channel(channel_name(channel, Quantity::velocity));
  if (rate < 0) return std::nullopt;
  WayAndRate sums;
  add_spans(stream, stream.channel(channel), rate, sums);
  if (!(sums.dd > 0.0) || !(sums.ii > 0.0)) return std::nullopt;

  const double slope = sums.di / sums.ii, correlation = sums.di / std::sqrt(sums.dd * sums.ii);
  const bool agrees = slope > 1.0 / kLargestLogFactor && slope < kLargestLogFactor;
  if (!(std::abs(correlation) > kCorrelated) || agrees) return std::nullopt;
  return RateContradiction{stream.name, channel, slope, correlation};
}

/// Of two trials.
bool same(const RateContradiction& a, const RateContradiction& b) {
  return a.stream == b.stream && a.channel == b.channel &&
         std::abs(a.slope / b.slope - 1.0) < kUnitWithin;
}

double median_spacing(const Stream& stream) {
  std::vector<double> steps;
  for (Eigen::Index k = 1; k < stream.time.size(); ++k)
    steps.push_back(stream.time[k] - stream.time[k - 1]);
  if (steps.empty()) return kNaN;
  std::nth_element(steps.begin(), steps.begin() + std::ssize(steps) / 2, steps.end());
  return steps[steps.size() / 2];
}

}  // namespace

std::vector<RateContradiction> rate_contradictions(const Dataset& dataset) {
  std::vector<RateContradiction> found;
  for (const Trial& trial : dataset.trials)
    for (const Stream& stream : trial.streams)
      for (const std::string& channel : stream.channels) {
        const auto own = contradiction_in(stream, channel);
        if (!own) continue;
        auto alike = std::find_if(found.begin(), found.end(), [&](const RateContradiction& other) {
          return same(other, *own);
        });
        if (alike == found.end()) alike = found.insert(alike, *own);
        alike->trials.push_back(trial.name);
      }
  return found;
}

std::string to_text(const RateContradiction& found) {
  return fmt::format(
      "{0}.{1} moves {2:.3g} times as far as {1}_velocity says (correlation {3:.2f}, {5}){4}",
      found.stream, found.channel, found.slope, found.correlation, meaning_of(found.slope),
      fmt::join(found.trials, ", "));
}

std::vector<std::string> rate_notes(const Dataset& dataset) {
  std::vector<std::string> notes;
  std::set<std::string> said;
  for (const Trial& trial : dataset.trials)
    for (const Stream& stream : trial.streams) {
      const double rate = 1.0 / median_spacing(stream);
      if (!std::isfinite(stream.rate_hz) || !std::isfinite(rate) ||
          std::abs(rate / stream.rate_hz - 1.0) < kRateOff || !said.insert(stream.name).second)
        continue;
      notes.push_back(fmt::format("{}: stated at {:.4g} Hz, its stamps are at {:.4g} Hz ({})",
                                  stream.name, stream.rate_hz, rate, trial.name));
    }
  return notes;
}

}  // namespace jaculus::trajectory
