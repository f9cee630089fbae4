#include "simulation/experiment/uncertain_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "jaculus/core/yaml.h"

namespace jaculus::simulation {
namespace {

/// Whether `path` is meant by `pattern`, in which "*" stands for one part between dots.
bool matches(const std::string& pattern, const std::string& path) {
  std::size_t i = 0, j = 0;
  while (i < pattern.size() && j < path.size()) {
    if (pattern[i] == '*') {
      ++i;
      while (j < path.size() && path[j] != '.') ++j;
    } else if (pattern[i++] != path[j++]) {
      return false;
    }
  }
  return i == pattern.size() && j == path.size();
}

}  // namespace

std::vector<model::ModelValue> values_named(const std::string& pattern,
                                            const std::vector<model::ModelValue>& all,
                                            const std::string& robot, const InputPlace& place) {
  std::vector<model::ModelValue> found;
  std::vector<std::string> names;
  for (const model::ModelValue& value : all) {
    names.push_back(value.path);
    if (matches(pattern, value.path) || matches(pattern, value.alias)) found.push_back(value);
  }
  if (!found.empty()) return found;

  throw InputError(place, fmt::format("'{}' is no model value of {}{}; allowed: {}", pattern, robot,
                                      yaml::did_you_mean(pattern, names), fmt::join(names, ", ")));
}

}  // namespace jaculus::simulation
