#include "studies/grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace jaculus::studies {
namespace {

void add_range(const yaml::Node& node, const Parameter& p, std::vector<double>& values) {
  node.only({"from", "to", "count", "spacing"});
  const double from = node.at("from").number(p.dimension, p.allowed);
  const double to = node.at("to").number(p.dimension, p.allowed);
  const int count = node.at("count").integer(2, kMostGridPoints);
  const bool logarithmic =
      node.has("spacing") && node.at("spacing").choice({"linear", "log"}) == "log";
  if (!(from < to)) throw node.error(fmt::format("from {} to {}; from must be below to", from, to));
  if (logarithmic && from <= 0.0)
    throw node.error(fmt::format("from is {}; spacing: log needs it above 0", from));
  for (int i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / (count - 1);
    const double between = logarithmic ? from * std::pow(to / from, share)
                                       : (from * (count - 1 - i) + to * i) / (count - 1);
    values.push_back(i == 0 ? from : (i + 1 == count ? to : between));
  }
}

Axis read_axis(const std::string& name, const yaml::Node& node) {
  Axis axis;
  axis.parameter = &find_parameter(name, node);
  axis.node = node;
  const Parameter& p = *axis.parameter;

  if (node.is_map()) {
    add_range(node, p, axis.values);
  } else if (node.is_list()) {
    for (const yaml::Node& item : node.items()) {
      if (item.is_map()) {
        add_range(item, p, axis.values);
      } else {
        axis.values.push_back(item.number(p.dimension, p.allowed));
      }
    }
  } else {
    axis.values.push_back(node.number(p.dimension, p.allowed));
  }

  if (axis.values.empty()) throw node.error("an empty axis; give one value or more");
  std::sort(axis.values.begin(), axis.values.end());
  const auto twin = std::adjacent_find(axis.values.begin(), axis.values.end());
  if (twin != axis.values.end())
    throw node.error(fmt::format("{} is there twice; values must differ", *twin));

  return axis;
}

// Setting one parameter unsets its alternative, which shows here.
bool undoes(const Parameter& a, const Parameter& b) {
  ReorientationSetup s;
  a.set(s, 0.5);
  b.set(s, 0.5);
  return std::isnan(a.get(s));
}

}  // namespace

std::vector<Axis> read_grid(const yaml::Node& node) {
  std::vector<Axis> axes;
  double size = 1.0;
  for (const auto& [name, value] : node.entries()) {
    axes.push_back(read_axis(name, value));
    for (std::size_t i = 0; i + 1 < axes.size(); ++i) {
      if (undoes(*axes[i].parameter, *axes.back().parameter)) {
        throw value.error(
            fmt::format("{} and {} exclude one another; keep one", axes[i].parameter->name, name));
      }
    }
    size *= static_cast<double>(axes.back().values.size());
  }
  if (axes.empty())
    throw node.error("an empty grid; name one parameter or more, or leave `grid` out");
  if (size > kMostGridPoints)
    throw node.error(fmt::format("{} points; at most {} are allowed", size, kMostGridPoints));
  return axes;
}

int grid_size(const std::vector<Axis>& axes) {
  int size = 1;
  for (const Axis& axis : axes) size *= count_of(axis.values);
  return size;
}

std::vector<double> grid_point(const std::vector<Axis>& axes, int index) {
  std::vector<double> point(axes.size());
  for (std::size_t i = axes.size(); i-- > 0;) {
    const int n = count_of(axes[i].values);
    point[i] = axes[i].values[index % n];
    index /= n;
  }
  return point;
}

}  // namespace jaculus::studies
