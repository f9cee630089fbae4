#include "diagnosis/remainder/pattern_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace jaculus::diagnosis {
namespace {

constexpr double kReach =
    10.0;  ///< of a size that is usual or found, where a fit may take it [chosen]

std::string line_of(const PatternParameter& own, double found) {
  const double scale = std::min(found, std::max(own.upper, -own.lower));
  const double most = kReach * scale;
  return parameter_line(own.name, own.unit, 0.0,
                        {std::max(own.lower, -most), std::min(own.upper, most)}, scale);
}

}  // namespace

std::string constant_line(const std::string& name, const std::string& unit, double value) {
  return fmt::format("  {}: {{unit: {}, value: {:.6g}}}\n", name, unit, value);
}

std::string parameter_line(const std::string& name, const std::string& unit, double nominal,
                           const Bounds& bounds, double scale) {
  return fmt::format(
      "  {}: {{unit: {}, nominal: {:.4g}, bounds: [{:.4g}, {:.4g}], scale: {:.4g}}}\n", name, unit,
      nominal, bounds.lower, bounds.upper, scale);
}

std::string size_line(const std::string& name, const std::string& unit, double found) {
  const double scale = std::max(std::abs(found), 1e-12);
  return parameter_line(name, unit, 0.0, {-kReach * scale, kReach * scale}, scale);
}

std::string pattern_file(const PlacePattern& pattern, const std::vector<double>& scales,
                         bool free_shape) {
  std::string parameters, constants;
  for (std::size_t k = 0; k < pattern.parameters.size(); ++k)
    parameters += line_of(pattern.parameters[k], scales[k]);
  for (const std::string& line : pattern.constants) constants += line;
  if (const auto& shape = pattern.shape) {
    if (free_shape)
      parameters += parameter_line(shape->name, shape->unit, shape->value,
                                   {shape->lower, shape->upper}, shape->scale);
    else
      constants += constant_line(shape->name, shape->unit, shape->value);
  }

  std::string text =
      fmt::format("format: jaculus-effect/1\nname: {}\ncaption: {}\nat: {}\nparameters:\n{}",
                  pattern.name, pattern.caption, pattern.where, parameters);
  if (!constants.empty()) text += "constants:\n" + constants;
  const auto add = [&](const char* key, const std::vector<std::string>& lines) {
    if (!lines.empty()) text += key;
    for (const std::string& line : lines) text += line;
  };
  add("values:\n", pattern.values);
  add("states:\n", pattern.states);
  for (const std::string& formula : pattern.formulas) text += formula;
  return text;
}

}  // namespace jaculus::diagnosis
