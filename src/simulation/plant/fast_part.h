#pragma once
// What settles far faster than the motion: joints that dry friction brings to rest, stiff hinges.

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulation/plant/mechanism.h"

namespace jaculus::simulation::detail {

/// A generalised force along `row` that falls by `damping` with its rate and by `stiffness` with
/// its way, and what a unit of it does to the accelerations.
struct FastPart {
  Row row{};               ///< d(rate)/dv
  double damping = 0.0;    ///< [N m s/rad, N s/m]
  double stiffness = 0.0;  ///< [N m/rad, N/m]
  Row response{};          ///< with the contacts that are closed [1/(kg m^2) and the like]

  /// How fast it settles or swings, with n coordinates [1/s].
  [[nodiscard]] double rate(int n) const {
    const double a = std::max(0.0, dot(row, response.data(), n));
    return std::max(damping * a, std::sqrt(stiffness * a));
  }
};

struct FastParts {
  int size = 0;  ///< coordinates: a state is (q, v, others)
  std::vector<FastPart> parts;

  /// Of the fastest [1/s].
  [[nodiscard]] double rate() const {
    double fastest = 0.0;
    for (const FastPart& part : parts) fastest = std::max(fastest, part.rate(size));
    return fastest;
  }
};

}  // namespace jaculus::simulation::detail
