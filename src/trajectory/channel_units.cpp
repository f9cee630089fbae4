#include "trajectory/channel_units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "core/unit_symbols.h"
#include "jaculus/core/error.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::trajectory {
namespace {

struct Rule {
  std::string_view text;
  std::vector<Dimension> dimensions;
};

const std::vector<Rule>& names() {
  static const std::vector<Rule> rules = {
      {"time", {dimension::time}}, {"x", {dimension::length}},   {"y", {dimension::length}},
      {"z", {dimension::length}},  {"roll", {dimension::angle}}, {"pitch", {dimension::angle}},
      {"yaw", {dimension::angle}},
  };
  return rules;
}

std::optional<ChannelUnit> convert(const std::string& unit,
                                   const std::vector<Dimension>& dimensions) {
  for (const Dimension& dimension : dimensions) {
    try {
      return ChannelUnit{parse_quantity("1 " + unit, dimension), unit_name(dimension)};
    } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): the next dimension is tried
    }
  }
  // Headers of other programs run units together: Nm, Nmm.
  const std::optional<std::string> parted = parted_unit(unit);
  return parted ? convert(*parted, dimensions) : std::nullopt;
}

}  // namespace

std::vector<Dimension> channel_dimensions(std::string_view channel) {
  for (const Rule& rule : names())
    if (channel == rule.text) return rule.dimensions;

  const Quantity quantity = parse_channel(channel).quantity;
  if (quantity != Quantity::position) return dimensions_of(quantity);

  if (channel.ends_with("_pitch")) return {dimension::angle};
  return {dimension::angle,
          dimension::length,
          dimension::none,
          dimension::time,
          dimension::angular_velocity,
          dimension::velocity,
          dimension::torque,
          dimension::force,
          dimension::current,
          dimension::voltage,
          dimension::acceleration};
}

ChannelUnit channel_unit(const Column& column, const std::string& place) {
  const std::vector<Dimension> dimensions = channel_dimensions(column.name);
  const std::string expected = unit_name(dimensions.front());
  const bool pure = dimensions == std::vector<Dimension>{dimension::none};
  if (column.unit.empty()) {
    if (pure) return {1.0, "-"};
    throw InputError(fmt::format("{}: column '{}' has no unit; allowed: '{} [{}]'{}", place,
                                 column.name, column.name, expected,
                                 dimensions.size() > 2 ? ", or '[-]' for a pure number" : ""));
  }
  if (const auto unit = convert(column.unit, dimensions)) return *unit;
  throw InputError(fmt::format(
      "{}: column '{} [{}]': allowed: a unit such as '[{}]'{}", place, column.name, column.unit,
      expected,
      dimensions.size() == 2 ? fmt::format(" or '[{}]'", unit_name(dimensions.back())) : ""));
}

std::string apart_of(const std::string& channel, const std::string& unit, int count) {
  // A joint's name leaves its dimension open, the base's names and suffixes don't.
  const bool joint = channel_dimensions(channel).size() > 2;
  const bool position =
      unit == unit_of(Quantity::position) || unit == unit_of(Quantity::position, true);
  if (count != 2 || !joint || !position) return {};
  return channel_name(channel, Quantity::apart);
}

}  // namespace jaculus::trajectory
