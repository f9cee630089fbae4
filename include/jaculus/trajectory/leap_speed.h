#pragma once
// The authors' way from motion capture to a leap's acceleration (Norby et al. 2021, section V-B),
// kept as it is so that figures compare, with its faults:
//   s_k = |(x, y)_k - (x, y)_0|,   u_k = mean of 3 of (s_k+1 - s_k)/(t_k+1 - t_k),
//   start = last sample with u < 0.005 m/s before the first with u > 0.1 m/s,
//   v = u(start + T) linearly interpolated,   a = v/T,
// T the plan's duration. The start fires while the robot creeps, differently by variant, and v is a
// mean over three frames past the plan's end: jaculus simulate shows the bias on a run whose true
// state is known.

#include <optional>

#include "jaculus/core/types.h"

namespace jaculus::trajectory {

struct LeapSpeed {
  double start = 0.0;         ///< by the rule above [s]
  double speed = 0.0;         ///< v [m/s]
  double acceleration = 0.0;  ///< v/T [m/s^2]
};

/// Moves by the start rule: the sample's time, or nothing where the speed never passes 0.1 m/s or
/// was never under 0.005 m/s before. `time`, `x`, `y` (may be empty) are samples; those with a gap
/// are left out. [s], [m]
std::optional<double> leap_start(const Vector& time, const Vector& x, const Vector& y);

/// The whole recipe; nothing where there is no start or the samples end before start + duration.
std::optional<LeapSpeed> leap_speed(const Vector& time, const Vector& x, const Vector& y,
                                    double duration);

}  // namespace jaculus::trajectory
