#pragma once
// Random states of a robot within its ranges, the same for a seed.

#include <cmath>
#include <random>

#include "jaculus/model/planar.h"

namespace jaculus::test_support {

struct RandomState {
  Vector q, v, a;  ///< n each
};

/// Coordinates in the middle 80 % of their ranges (unbounded ones in -1..1), rates within 3,
/// accelerations within 10.
inline RandomState random_state(const model::PlanarModel& model, std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const int n = model.size();
  RandomState s{Vector(n), Vector(n), Vector(n)};
  for (int i = 0; i < n; ++i) {
    const Bounds range = model.coordinates[i].range;
    const bool bounded = std::isfinite(range.lower) && std::isfinite(range.upper);
    s.q[i] = bounded
                 ? 0.5 * (range.lower + range.upper) + 0.4 * unit(rng) * (range.upper - range.lower)
                 : unit(rng);
    s.v[i] = 3.0 * unit(rng);
    s.a[i] = 10.0 * unit(rng);
  }
  return s;
}

}  // namespace jaculus::test_support
