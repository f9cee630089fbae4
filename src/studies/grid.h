#pragma once
// Grids over named parameters, as a study file writes them.
//
//   tail.length: [0.5 m, 0.75 m, 1 m]                          numbers
//   tail.normalised_inertia: {from: 0.01, to: 0.6, count: 60}  even, with ends (or spacing: log)
//   tail.normalised_inertia: [{from: ...}, 0.204]               both; sorted, equal ones refused
//
// The first axis turns slowest. Axes that a point sets are applied in order.

#include <vector>

#include "jaculus/core/yaml.h"
#include "studies/setup.h"

namespace jaculus::studies {

struct Axis {
  const Parameter* parameter = nullptr;
  std::vector<double> values;  ///< ascending, SI
  yaml::Node node;             ///< where it stands, for messages
};

/// The most points that a grid may have.
inline constexpr int kMostGridPoints = 1000000;

/// Reads a map of axes. Empty axes, equal values, more than kMostGridPoints, both of an
/// alternative: InputError.
std::vector<Axis> read_grid(const yaml::Node& node);

/// Product of the axes' sizes; 1 without axes.
int grid_size(const std::vector<Axis>& axes);

/// The axes' values at point `index` of grid_size().
std::vector<double> grid_point(const std::vector<Axis>& axes, int index);

}  // namespace jaculus::studies
