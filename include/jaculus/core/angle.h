#pragma once

#include <numbers>

namespace jaculus {

/// Degrees in a radian.
inline constexpr double kDegrees = 180.0 / std::numbers::pi;

}  // namespace jaculus
