#include "diagnosis/remainder/pattern_file.h"

#include <fmt/format.h>

#include <cmath>

namespace jaculus::diagnosis {
namespace {

constexpr double kReach = 10.0;                          ///< scales that a parameter may reach
constexpr double kSlackSpread = 0.5, kSlackRange = 3.0;  ///< of a slack; grids are 2.5 apart
constexpr double kWaveSpread = 0.05, kWaveRange = 0.2;   ///< of a period

std::string parameter_line(const PatternParameter& own, double scale) {
  return fmt::format("  {}: {{unit: {}, nominal: 0, bounds: [{:.4g}, {:.4g}], scale: {:.4g}}}\n",
                     own.name, own.unit, -kReach * scale, kReach * scale, scale);
}

}  // namespace

std::string constant_line(const std::string& name, const std::string& unit, double value) {
  return fmt::format("  {}: {{unit: {}, value: {:.6g}}}\n", name, unit, value);
}

std::string pattern_file(const PlacePattern& pattern, const std::vector<double>& scales,
                         bool free_shape) {
  std::string parameters, constants;
  for (std::size_t k = 0; k < pattern.parameters.size(); ++k)
    parameters += parameter_line(pattern.parameters[k], scales[k]);
  for (const std::string& line : pattern.constants) constants += line;
  if (std::isfinite(pattern.period)) {
    const double p = pattern.period;
    if (free_shape)
      parameters += fmt::format(
          "  period: {{unit: {}, nominal: {:.4g}, bounds: [{:.4g}, {:.4g}], scale: {:.4g}}}\n",
          pattern.period_unit, p, (1.0 - kWaveRange) * p, (1.0 + kWaveRange) * p, kWaveSpread * p);
    else
      constants += constant_line("period", pattern.period_unit, p);
  }

  if (std::isfinite(pattern.slack)) {
    if (free_shape)
      parameters +=
          fmt::format("  slack: {{unit: m, nominal: {:.4g}, bounds: [0, {:.4g}], scale: {:.4g}}}\n",
                      pattern.slack, kSlackRange * pattern.slack, kSlackSpread * pattern.slack);
    else
      constants += constant_line("slack", "m", pattern.slack);
  }

  std::string text =
      fmt::format("format: jaculus-effect/1\nname: {}\ncaption: {}\nat: {}\nparameters:\n{}",
                  pattern.name, pattern.caption, pattern.where, parameters);
  if (!constants.empty()) text += "constants:\n" + constants;
  for (const std::string& formula : pattern.formulas) text += formula;
  return text;
}

}  // namespace jaculus::diagnosis
