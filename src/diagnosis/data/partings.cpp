#include "diagnosis/data/partings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "diagnosis/data/scatter.h"

namespace jaculus::diagnosis {
namespace {

using trajectory::Stream;

constexpr std::size_t kAtRest = 5;      ///< samples at least, whose median is what zeros differ by
constexpr double kBeyondScatter = 5.0;  ///< deviations; two samples in a row are so by 1 in 1e12

/// What sides differ by, gaps left out.
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

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What zeros differ by: before the command at rest, or where there is no rest at first; under a
/// logged input at the middle of what there is.
double zero_of(const Apart& apart, const ObservedDataset& observed) {
  if (observed.measured_input) return median(apart.value);
  std::vector<double> rest;
  for (std::size_t i = 0; i < apart.time.size() && (apart.time[i] < 0.0 || rest.size() < kAtRest);
       ++i)
    if (apart.time[i] >= observed.window_start) rest.push_back(apart.value[i]);
  return median(rest.empty() ? apart.value : rest);
}

/// Where values began to rise to the one at `at`: a foot left the floor there, and its side's
/// torque has moved the leg alone ever since. Noise may stop the search, but not
/// above half of `limit`.
std::size_t start_of_rise(const std::vector<double>& values, std::size_t at, double limit) {
  while (at > 0 && (values[at - 1] < values[at] || values[at - 1] > 0.5 * limit)) --at;
  return at;
}

/// Of one channel about its zero; nothing where its sides stay together.
std::optional<Parting> parting_of(const Apart& apart, double from, double to, double limit) {
  std::optional<Parting> found;
  for (std::size_t i = 0; i + 1 < apart.time.size() && apart.time[i] <= to; ++i) {
    if (apart.time[i] < from) continue;
    if (!found && apart.value[i] > limit && apart.value[i + 1] > limit) {
      found.emplace();
      found->from = std::max(from, apart.time[start_of_rise(apart.value, i, limit)]);
    }
    if (found) found->most = std::max(found->most, apart.value[i]);
  }
  return found;
}

bool is_tracked(const std::string& stream, const std::string& channel) {
  return stream == trajectory::kMocapStream &&
         (channel == "y" || channel == "roll" || channel == "yaw");
}

/// The joint of the model whose sides a channel compares; -1 for any other channel.
int body_of_sides(const model::PlanarModel& model, const std::string& channel) {
  const trajectory::ChannelName name = trajectory::parse_channel(channel);
  return name.quantity == trajectory::Quantity::apart ? model.body_of_joint(name.of) : -1;
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

bool tells_of_plane(const model::PlanarModel& model, const std::string& stream,
                    const std::string& channel) {
  return is_tracked(stream, channel) || body_of_sides(model, channel) >= 0;
}

std::optional<Parting> first_parting(const ObservedDataset& observed,
                                     const trajectory::Trial& trial, double from, double to,
                                     const Settings& settings) {
  std::optional<Parting> first;
  for (const Stream& stream : trial.streams) {
    for (int c = 0; c < count_of(stream.channels); ++c) {
      const int body = body_of_sides(observed.model, stream.channels[c]);
      if (body < 0) continue;
      Apart apart = without_gaps(stream, c);
      if (apart.value.empty()) continue;
      const bool slides = observed.model.bodies[body].kind == model::JointKind::prismatic;
      const double apart_by = settings.sides_apart * (slides ? settings.lever : 1.0);
      const double limit = std::max(apart_by, kBeyondScatter * scatter_of(apart.value));
      const double zero = zero_of(apart, observed);
      for (double& value : apart.value) value = std::abs(value - zero);
      std::optional<Parting> found = parting_of(apart, from, to, limit);
      if (!found || (first && first->from <= found->from)) continue;

      first = std::move(found);
      first->dataset = observed.name();
      first->trial = trial.name;
      first->joint = trajectory::parse_channel(stream.channels[c]).of;
      first->unit = stream.units[c];
    }
  }
  return first;
}

std::optional<Parting> as_one(const std::vector<Parting>& partings) {
  std::optional<Parting> first;
  double most = 0.0;
  for (const Parting& one : partings) {
    most = std::max(most, one.most);
    if (!first || one.from < first->from) first = one;
  }
  if (first) first->most = most;
  return first;
}

std::string note_of(const std::vector<Parting>& partings, int trials) {
  const auto earliest =
      std::min_element(partings.begin(), partings.end(),
                       [](const Parting& a, const Parting& b) { return a.from < b.from; });
  return fmt::format(
      "{}: left and right part in {} of {} trials, at {} of {} from {:.3f} s on (by {:.2g} {}): a "
      "model of the plane moves them as one, so a trial's data are left out from there on, or "
      "until "
      "a window begins with both together",
      earliest->dataset, partings.size(), trials, earliest->joint, earliest->trial, earliest->from,
      earliest->most, earliest->unit);
}

}  // namespace jaculus::diagnosis
