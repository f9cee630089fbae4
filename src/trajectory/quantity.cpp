#include "jaculus/trajectory/quantity.h"

#include <algorithm>
#include <cassert>

namespace jaculus::trajectory {
namespace {

/// What a quantity is called, and its dimensions: of what turns, then of what slides.
struct Row {
  Quantity quantity;
  const char* name;
  std::vector<Dimension> dimensions;
};

const std::vector<Row>& rows() {
  namespace d = dimension;
  static const std::vector<Row> all = {
      {Quantity::position, "position", {d::angle, d::length}},
      {Quantity::velocity, "velocity", {d::angular_velocity, d::velocity}},
      {Quantity::acceleration, "acceleration", {d::angular_acceleration, d::acceleration}},
      {Quantity::torque, "torque", {d::torque, d::force}},
      {Quantity::motor_torque, "motor_torque", {d::torque, d::force}},
      {Quantity::current, "current", {d::current}},
      {Quantity::voltage, "voltage", {d::voltage}},
      {Quantity::duty, "duty", {d::none}},
      {Quantity::force, "force", {d::force}},
      {Quantity::force_x, "force_x", {d::force}},
      {Quantity::force_z, "force_z", {d::force}},
      {Quantity::apart, "apart", {d::angle, d::length}},
  };
  return all;
}

}  // namespace

const NameTable<Quantity>& quantity_names() {
  static const NameTable<Quantity> table = [] {
    std::vector<NameTable<Quantity>::Row> names;
    for (const Row& row : rows()) names.emplace_back(row.quantity, row.name);
    return NameTable<Quantity>(std::move(names));
  }();
  return table;
}

const char* name_of(Quantity quantity) { return quantity_names().name(quantity); }

const NameTable<Quantity>& command_names() {
  static const NameTable<Quantity> table =
      quantity_names().only({Quantity::torque, Quantity::duty, Quantity::voltage});
  return table;
}

const std::vector<Dimension>& dimensions_of(Quantity quantity) {
  const auto row = std::find_if(rows().begin(), rows().end(),
                                [&](const Row& own) { return own.quantity == quantity; });
  assert(row != rows().end() && "every quantity has a row");
  return row->dimensions;
}

std::string unit_of(Quantity quantity, bool slides) {
  const std::vector<Dimension>& dimensions = dimensions_of(quantity);
  return unit_name(slides ? dimensions.back() : dimensions.front());
}

ChannelName parse_channel(std::string_view name) {
  ChannelName found{std::string(name), Quantity::position};
  for (const Row& row : rows()) {
    const std::string suffix = std::string("_") + row.name;
    if (row.quantity == Quantity::position || !name.ends_with(suffix)) continue;

    // Of two suffixes the longer one counts, and a name is more than its suffix.
    const std::size_t length = name.size() - suffix.size();
    if (length > 0 && length < found.of.size()) {
      found = {std::string(name.substr(0, length)), row.quantity};
    }
  }
  return found;
}

std::string channel_name(std::string_view of, Quantity quantity) {
  if (quantity == Quantity::position) return std::string(of);
  return std::string(of) + "_" + name_of(quantity);
}

}  // namespace jaculus::trajectory
