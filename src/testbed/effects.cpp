#include "jaculus/testbed/effects.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"

namespace jaculus::testbed {
namespace {

using Values = std::vector<double>;

[[noreturn]] void refuse(const std::string& given, const std::string& why, const std::string& name,
                         const std::vector<std::string>& allowed) {
  throw InputError(fmt::format("--effect {}: {}{}; allowed: {}", given, why,
                               yaml::did_you_mean(name, allowed), fmt::join(allowed, ", ")));
}

double number_of(const std::string& given, const std::string& text, const BenchParameter& p) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code == std::errc() && end == text.data() + text.size() &&
      value >= std::min(p.usual, p.lower) && value <= std::max(p.usual, p.upper)) {
    return value;
  }
  throw InputError(fmt::format("--effect {}: {} '{}' given; allowed: a number from {} to {} {}",
                               given, p.name, text, std::min(p.usual, p.lower),
                               std::max(p.usual, p.upper), p.unit));
}

std::vector<std::string> split(const std::string& text, char by) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t to = std::min(text.find(by, from), text.size());
    parts.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return parts;
}

/// "parameter=value,..." over the usual values.
Values values_of(const std::string& given, const std::string& text, const BenchEffect& effect) {
  std::vector<std::string> names;
  for (const BenchParameter& p : effect.parameters) names.push_back(p.name);
  Values values = usual_values(effect);
  std::vector<bool> seen(values.size(), false);

  for (const std::string& part : split(text, ',')) {
    const auto equals = part.find('=');
    const std::string key = part.substr(0, equals);
    const auto found = std::find(names.begin(), names.end(), key);
    if (found == names.end()) refuse(given, fmt::format("unknown parameter '{}'", key), key, names);
    const auto index = found - names.begin();
    if (seen[index])
      throw InputError(fmt::format("--effect {}: '{}' stands twice; allowed: once", given, key));
    seen[index] = true;
    values[index] = number_of(given, equals == std::string::npos ? "" : part.substr(equals + 1),
                              effect.parameters[index]);
  }

  if (std::find(seen.begin(), seen.end(), true) == seen.end()) {
    throw InputError(fmt::format("--effect {}: no value given; allowed: {}:{}=VALUE", given,
                                 effect.name, names.front()));
  }
  return values;
}

}  // namespace

std::string name_without_joint(const std::string& name) { return name.substr(0, name.find('@')); }

const BenchEffect* find_bench_effect(const std::vector<BenchEffect>& effects,
                                     const std::string& name) {
  for (const BenchEffect& effect : effects)
    if (effect.name == name) return &effect;
  return nullptr;
}

std::vector<double> usual_values(const BenchEffect& effect) {
  std::vector<double> values;
  for (const BenchParameter& p : effect.parameters) values.push_back(p.usual);
  return values;
}

void apply_effect(const std::string& given, const std::vector<BenchEffect>& effects,
                  Changes& changes) {
  const auto colon = given.find(':');
  const std::string name = given.substr(0, colon);
  const BenchEffect* effect = find_bench_effect(effects, name);
  if (effect == nullptr) {
    std::vector<std::string> names;
    for (const BenchEffect& e : effects) names.push_back(e.name);
    refuse(given, fmt::format("unknown effect '{}' of this robot", name), name, names);
  }

  const std::string text = colon == std::string::npos ? "" : given.substr(colon + 1);
  effect->apply(values_of(given, text, *effect), changes);
}

}  // namespace jaculus::testbed
