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
  double speed = 0.0;      ///< of dry friction: the joint's rate [rad/s, m/s]
  double width = 0.0;      ///< of the rate's smoothed sign; 0: no dry friction [rad/s, m/s]

  /// Acceleration of its own rate by a unit of its force, with n coordinates.
  [[nodiscard]] double mobility(int n) const { return std::max(0.0, dot(row, response.data(), n)); }
  /// How fast it settles or swings, with n coordinates [1/s].
  [[nodiscard]] double rate(int n) const { return rate_of(*this, n); }
  /// The same with the slopes of this part at another state, its response as here.
  [[nodiscard]] double rate_of(const FastPart& there, int n) const {
    const double a = mobility(n);
    return std::max(there.damping * a, std::sqrt(there.stiffness * a));
  }
};

struct FastParts {
  int size = 0;  ///< coordinates: a state is (q, v, others)
  std::vector<FastPart> parts;

  /// Whether what is fast over a time [s], here or there, is as fast there, within a factor of two.
  /// `there`: the same parts at another state, their responses not needed.
  [[nodiscard]] bool last(const std::vector<FastPart>& there, double time) const {
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const auto [slower, faster] =
          std::minmax({parts[k].rate(size), parts[k].rate_of(there[k], size)});
      if (time * faster > 1.0 && faster > 2.0 * slower) return false;
    }
    return true;
  }

  /// Of the fastest [1/s].
  [[nodiscard]] double rate() const {
    double fastest = 0.0;
    for (const FastPart& part : parts) fastest = std::max(fastest, part.rate(size));
    return fastest;
  }
};

}  // namespace jaculus::simulation::detail
