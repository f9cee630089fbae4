#include "diagnosis/data/partings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "diagnosis/data/scatter.h"
#include "jaculus/diagnosis/physical.h"

namespace jaculus::diagnosis {
namespace {

using trajectory::Stream;

/// Channels of a tracked body that the plane has not, and their units.
constexpr std::array<std::pair<const char*, const char*>, 3> kOutOfPlane = {
    {{"y", "m"}, {"roll", "rad"}, {"yaw", "rad"}}};

/// What zeros differ by: before the command at rest, or where there is no rest at first; under a
/// logged input at the middle of what there is.
double zero_of(const Sides& sides, const ObservedDataset& observed, const Settings& settings) {
  if (observed.measured_input) return median(sides.apart);
  std::vector<double> rest;
  const auto still = [&](double t) { return t < 0.0 || count_of(rest) < settings.sides_at_rest; };
  for (std::size_t i = 0; i < sides.time.size() && still(sides.time[i]); ++i)
    if (sides.time[i] >= observed.window_start) rest.push_back(sides.apart[i]);
  return median(rest.empty() ? sides.apart : rest);
}

/// Samples from `first` to `last`, and their mean.
struct Span {
  std::size_t first = 0, last = 0;
  double mean = 0.0;  ///< [unit]

  [[nodiscard]] double count() const { return static_cast<double>(last - first + 1); }
};

/// The samples up to `last` that are less than `rise` before it.
Span span_up_to(const Sides& sides, std::size_t last) {
  Span span{last, last, sides.apart[last]};
  while (span.first > 0 && sides.time[last] - sides.time[span.first - 1] < sides.rise)
    span.mean += sides.apart[--span.first];
  span.mean /= span.count();
  return span;
}

/// Where what sides differ by began to move to the sample at `at`: a foot left the floor there, and
/// its side's torque has moved the leg alone ever since. It goes back by spans while the one before
/// is behind by more than noise, then to the last sample before two that have left that span.
std::size_t start_of_rise(const Sides& sides, std::size_t at) {
  const double sign = sides.apart[at] < 0.0 ? -1.0 : 1.0;
  Span now = span_up_to(sides, at);
  while (now.first > 0) {
    const Span before = span_up_to(sides, now.first - 1);
    const double noise = sides.noise * std::sqrt(1.0 / now.count() + 1.0 / before.count());
    if (sign * (now.mean - before.mean) <= noise) break;
    now = before;
  }

  const auto moved_on = [&](std::size_t i) {
    return sign * (sides.apart[i] - now.mean) > sides.noise;
  };
  std::size_t start = now.last;
  while (start + 1 < at && !(moved_on(start + 1) && moved_on(start + 2))) ++start;
  return start;
}

/// Of one joint, two samples in a row; nothing where its sides stay together.
std::optional<Parting> parting_of(const Sides& sides, double from, double to) {
  std::optional<Parting> found;
  for (std::size_t i = 0; i + 1 < sides.apart.size() && sides.time[i] <= to; ++i) {
    if (sides.time[i] < from) continue;
    const double both = std::min(std::abs(sides.apart[i]), std::abs(sides.apart[i + 1]));
    if (!found && both > sides.limit) {
      found = sides.names;
      found->from = std::max(from, sides.time[start_of_rise(sides, i)]);
    }
    if (found) found->most = std::max(found->most, both);
  }
  return found;
}

bool is_tracked(const std::string& stream, const std::string& channel) {
  return stream == trajectory::kMocapStream &&
         std::any_of(kOutOfPlane.begin(), kOutOfPlane.end(),
                     [&](const auto& own) { return channel == own.first; });
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
std::string moved_text(const char* channel, const char* unit, const std::vector<double>& by) {
  const ShownUnit shown = shown_unit(unit);
  const Vector all = Eigen::Map<const Vector>(by.data(), std::ssize(by)) / shown.size;
  const double mean = all.mean();
  std::string text = fmt::format("{} {:.2g} {}", channel, mean, shown.unit);
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
  std::vector<std::string> parts;
  for (const auto& [channel, unit] : kOutOfPlane) {
    const std::vector<double> by = moved(dataset, channel, begin, end);
    if (!by.empty()) parts.push_back(moved_text(channel, unit, by));
  }
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

std::vector<Sides> sides_of(const ObservedDataset& observed, const trajectory::Trial& trial,
                            const Settings& settings) {
  std::vector<Sides> found;
  for (const Stream& stream : trial.streams) {
    for (int c = 0; c < count_of(stream.channels); ++c) {
      const int body = body_of_sides(observed.model, stream.channels[c]);
      if (body < 0) continue;
      Sides sides;
      for (Eigen::Index i = 0; i < stream.time.size(); ++i) {
        if (!std::isfinite(stream.values(c, i))) continue;
        sides.time.push_back(stream.time[i]);
        sides.apart.push_back(stream.values(c, i));
      }
      if (sides.apart.empty()) continue;

      const model::PlanarBody& own = observed.model.bodies[body];
      sides.names.dataset = observed.name();
      sides.names.trial = trial.name;
      sides.names.joint = own.joint;
      sides.names.unit = stream.units[c];
      const double lever = own.kind == model::JointKind::prismatic ? settings.lever : 1.0;
      const double scatter = scatter_of(sides.apart);
      sides.limit = std::max(settings.sides_apart * lever, settings.sides_scatter * scatter);
      sides.noise = settings.sides_moved * scatter;
      sides.rise = settings.sides_rise;
      const double zero = zero_of(sides, observed, settings);
      for (double& value : sides.apart) value -= zero;
      found.push_back(std::move(sides));
    }
  }
  return found;
}

std::optional<Parting> first_parting(const std::vector<Sides>& sides, double from, double to) {
  std::optional<Parting> first;
  for (const Sides& own : sides) {
    const std::optional<Parting> found = parting_of(own, from, to);
    if (found && (!first || found->from < first->from)) first = found;
  }
  return first;
}

const Parting* earliest(const std::vector<Parting>& partings) {
  const auto first =
      std::min_element(partings.begin(), partings.end(),
                       [](const Parting& a, const Parting& b) { return a.from < b.from; });
  return first == partings.end() ? nullptr : &*first;
}

std::optional<Parting> as_one(const std::vector<Parting>& partings) {
  const Parting* first = earliest(partings);
  if (first == nullptr) return std::nullopt;
  Parting one = *first;
  for (const Parting& own : partings) one.most = std::max(one.most, own.most);
  return one;
}

std::string note_of(const std::vector<Parting>& partings, int trials) {
  const Parting* first = earliest(partings);
  assert(first != nullptr);
  return fmt::format(
      "{}: left and right part in {} of {} trials, at {} of {} from {:.3f} s on (by {:.2g} {}): a "
      "model of the plane moves them as one, so a trial's data are left out from there on, or "
      "until "
      "a window begins with both together",
      first->dataset, partings.size(), trials, first->joint, first->trial, first->from, first->most,
      first->unit);
}

}  // namespace jaculus::diagnosis
