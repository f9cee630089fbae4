#include "diagnosis/data/partings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

namespace jaculus::diagnosis {
namespace {

using trajectory::Stream;

constexpr Eigen::Index kAtRest = 5;  ///< first samples, whose median is what zeros differ by

/// Samples of a channel that are no gaps.
struct Apart {
  std::vector<double> time, value;
};

Apart without_gaps(const Stream& stream, int channel) {
  Apart out;
  for (Eigen::Index i = 0; i < stream.time.size(); ++i) {
    const double value = stream.values(channel, i);
    if (!std::isfinite(value)) continue;
    out.time.push_back(stream.time[i]);
    out.value.push_back(value);
  }
  return out;
}

double median_of_first(const std::vector<double>& values) {
  std::vector<double> first(values.begin(), values.begin() + std::min(kAtRest, std::ssize(values)));
  const auto middle = first.begin() + std::ssize(first) / 2;
  std::nth_element(first.begin(), middle, first.end());
  return *middle;
}

/// Where values began to rise to the one at `at`: a foot left the floor there, and its side's torque
/// has moved the leg alone ever since.
std::size_t start_of_rise(const std::vector<double>& values, std::size_t at) {
  while (at > 0 && values[at - 1] < values[at]) --at;
  return at;
}

/// Of one channel; nothing where its sides stay together.
std::optional<Parting> parting_of(Apart apart, double from, double to, double limit) {
  if (apart.value.empty()) return std::nullopt;
  const double zero = median_of_first(apart.value);
  for (double& value : apart.value) value = std::abs(value - zero);

  std::optional<Parting> found;
  for (std::size_t i = 0; i + 1 < apart.time.size() && apart.time[i] <= to; ++i) {
    if (apart.time[i] < from) continue;
    if (!found && apart.value[i] > limit && apart.value[i + 1] > limit) {
      found.emplace();
      found->from = std::max(from, apart.time[start_of_rise(apart.value, i)]);
    }
    if (found) found->most = std::max(found->most, apart.value[i]);
  }
  return found;
}

/// Of a channel from its first sample since `begin` to its last up to `end`; NaN without both.
double moved(const Stream& stream, int channel, double begin, double end) {
  double first = kNaN, last = kNaN;
  for (Eigen::Index i = 0; i < stream.time.size() && stream.time[i] <= end; ++i) {
    const double value = stream.values(channel, i);
    if (stream.time[i] < begin || !std::isfinite(value)) continue;
    if (std::isnan(first)) first = value;
    last = value;
  }
  return last - first;
}

/// In every trial that tracks it.
std::vector<double> moved(const trajectory::Dataset& dataset, const std::string& channel,
                          double begin, double end) {
  std::vector<double> out;
  for (const trajectory::Trial& trial : dataset.trials) {
    const Stream* stream = trial.stream(trajectory::kMocapStream);
    const int index = stream == nullptr ? -1 : stream->channel(channel);
    const double by = index < 0 ? kNaN : moved(*stream, index, begin, end);
    if (std::isfinite(by)) out.push_back(by);
  }
  return out;
}

/// "roll -1.9 deg (0.13 from trial to trial)".
std::string moved_text(const char* channel, const char* unit, double factor,
                       const std::vector<double>& by) {
  const Vector all = factor * Eigen::Map<const Vector>(by.data(), std::ssize(by));
  const double mean = all.mean();
  std::string text = fmt::format("{} {:.2g} {}", channel, mean, unit);
  if (all.size() > 1) {
    const double freedom = static_cast<double>(by.size()) - 1.0;
    const double scatter = std::sqrt((all.array() - mean).square().sum() / freedom);
    text += fmt::format(" ({:.2g} from trial to trial)", scatter);
  }
  return text;
}

}  // namespace

std::string out_of_plane(const trajectory::Dataset& dataset, const std::string& label, double begin,
                         double end) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  std::vector<std::string> parts;
  const auto add = [&](const char* channel, const char* unit, double factor) {
    const std::vector<double> by = moved(dataset, channel, begin, end);
    if (!by.empty()) parts.push_back(moved_text(channel, unit, factor, by));
  };
  add("y", "mm", 1e3);
  add("roll", "deg", kDegrees);
  add("yaw", "deg", kDegrees);
  if (parts.empty()) return {};
  return fmt::format(
      "{}: the body leaves the plane by {} at {:.2g} s; of that the model holds nothing, and what "
      "repeats tells that left and right differ",
      label, fmt::join(parts, ", "), end);
}

std::optional<Parting> first_parting(const trajectory::Trial& trial, double from, double to,
                                     double limit) {
  std::optional<Parting> first;
  for (const Stream& stream : trial.streams) {
    for (int c = 0; c < count_of(stream.channels); ++c) {
      const trajectory::ChannelName name = trajectory::parse_channel(stream.channels[c]);
      if (name.quantity != trajectory::Quantity::apart) continue;
      std::optional<Parting> found = parting_of(without_gaps(stream, c), from, to, limit);
      if (!found || (first && first->from <= found->from)) continue;

      first = std::move(found);
      first->trial = trial.name;
      first->joint = name.of;
      first->unit = stream.units[c];
    }
  }
  return first;
}

std::string note_of(const std::string& dataset, const std::vector<Parting>& partings) {
  const auto earliest =
      std::min_element(partings.begin(), partings.end(),
                       [](const Parting& a, const Parting& b) { return a.from < b.from; });
  std::set<std::string> trials;
  for (const Parting& one : partings) trials.insert(one.trial);
  return fmt::format(
      "{}: left and right part in {} of its trials, at {} of {} from {:.3f} s on (by {:.2g} {}): a "
      "model of the plane moves them as one, so a trial's data are left out from there on",
      dataset, trials.size(), earliest->joint, earliest->trial, earliest->from, earliest->most,
      earliest->unit);
}

}  // namespace jaculus::diagnosis
