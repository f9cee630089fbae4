#pragma once
// A value by name, with what holds where there is none.

#include <map>
#include <string>

namespace jaculus::simulation {

inline double value_or(const std::map<std::string, double>& values, const std::string& key,
                       double otherwise) {
  const auto found = values.find(key);
  return found == values.end() ? otherwise : found->second;
}

}  // namespace jaculus::simulation
