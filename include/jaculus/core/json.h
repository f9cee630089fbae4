#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

namespace jaculus {

/// JSON has neither NaN nor infinity; null says "none".
inline nlohmann::ordered_json json_number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace jaculus
