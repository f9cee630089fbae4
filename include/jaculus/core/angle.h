#pragma once

#include <cmath>
#include <numbers>

#include "jaculus/core/types.h"

namespace jaculus {

/// Degrees in a radian.
inline constexpr double kDegrees = 180.0 / std::numbers::pi;

/// R(angle) v of types.h: a body's vector in the world, in v's unit.
inline Vec2 turned(double angle, const Vec2& v) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x() + s * v.y(), c * v.y() - s * v.x()};
}

}  // namespace jaculus
