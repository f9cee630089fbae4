#pragma once
// A body's way from rest.

#include "jaculus/core/types.h"

namespace jaculus::test {

/// x of a body that rests until 0 and then accelerates by a, sampled.
inline Vector accelerated(const Vector& time, double a) {
  return time.unaryExpr([a](double t) { return t > 0.0 ? 0.5 * a * t * t : 0.0; });
}

}  // namespace jaculus::test
