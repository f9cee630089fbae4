#include "jaculus/diagnosis/physical.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace jaculus::diagnosis {
namespace {

/// The shortest name that only one channel has.
std::string shown_name(const std::map<std::string, ChannelShrink>& channels,
                       const std::string& key) {
  const ChannelShrink& own = channels.at(key);
  const auto alike = [&](auto&& same) {
    return std::count_if(channels.begin(), channels.end(),
                         [&](const auto& other) { return same(other.second); });
  };
  if (alike([&](const ChannelShrink& c) { return c.channel == own.channel; }) == 1)
    return own.channel;
  const bool told_by_dataset = alike([&](const ChannelShrink& c) {
                                 return c.channel == own.channel && c.dataset == own.dataset;
                               }) == 1;
  return told_by_dataset ? own.dataset + "." + own.channel : key;
}

PhysicalGap judged_gap(const std::string& name, const ChannelShrink& channel,
                       const std::optional<double>& tolerance, double horizon) {
  const ShownUnit shown = shown_unit(channel.unit);
  PhysicalGap row{name, shown.unit, channel.horizons, {}};
  for (HorizonGap& gap : row.horizons) {
    for (double* value : {&gap.before, &gap.after, &gap.floor}) *value /= shown.size;
    if (gap.horizon == horizon) row.judged = gap;
  }
  if (!tolerance) return row;

  row.tolerance = *tolerance / shown.size;
  if (std::isfinite(row.judged.after)) row.met = row.judged.after <= *row.tolerance;
  if (std::isfinite(row.judged.before)) row.met_before = row.judged.before <= *row.tolerance;
  return row;
}

}  // namespace

ShownUnit shown_unit(const std::string& si) {
  if (si == "m") return {"mm", 1e-3};
  if (si == "rad") return {"deg", std::numbers::pi / 180.0};
  return {si, 1.0};
}

std::vector<PhysicalGap> physical_gaps(const HeldOut& gap, const Tolerances& tolerances,
                                       const std::optional<double>& horizon) {
  std::vector<PhysicalGap> rows;
  for (const auto& [key, channel] : gap.channels) {
    const auto found = tolerances.find(key);
    std::optional<double> tolerance;
    if (found != tolerances.end()) tolerance = found->second.value;
    rows.push_back(
        judged_gap(shown_name(gap.channels, key), channel, tolerance, horizon.value_or(kInfinity)));
  }
  for (const auto& [key, tolerance] : tolerances) {
    if (gap.channels.count(key) > 0) continue;
    const ShownUnit shown = shown_unit(tolerance.unit);
    rows.push_back({key, shown.unit, {}, {}, tolerance.value / shown.size});
  }
  return rows;
}

}  // namespace jaculus::diagnosis
