#pragma once
// What of a log contradicts itself, told without any model.
//
// Of a channel A and its rate A_velocity in one stream: over spans of 0.05 s or 4 samples,
// whichever is longer, the way D = A(t1) - A(t0) and the integral I of the rate by the trapezoidal
// rule,
//   slope b = sum D I/sum I^2,   correlation c = sum D I/sqrt(sum D^2 sum I^2),
// over a trial. They contradict one another where |c| is above 0.95 and b is outside [1/2, 2]: a
// sign, degrees beside radians, a rate before the gear. Differences of noise have no such
// correlation.

#include <string>
#include <vector>

#include "jaculus/trajectory/dataset.h"

namespace jaculus::trajectory {

// Chosen, not tuned: spans long beside a driver's filter and short beside a swing; a factor that no
// filter or scale error reaches and every wrong unit, sign or gear does.
inline constexpr double kLogSpan = 0.05;          ///< [s]
inline constexpr double kLargestLogFactor = 2.0;  ///< [-]

/// A position and a rate that contradict one another.
struct RateContradiction {
  std::string stream, channel;        ///< the position's
  double slope = 1.0;                 ///< b [-]
  double correlation = 0.0;           ///< c [-]
  std::vector<std::string> trials{};  ///< that have it, b alike within a tenth
};
std::vector<RateContradiction> rate_contradictions(const Dataset& dataset);
/// "joints.swing moves -1.00 times ...".
std::string to_text(const RateContradiction& found);

/// One sentence for each stream whose stamps have another rate than is stated, by a tenth or more
/// in the median of their spacing.
std::vector<std::string> rate_notes(const Dataset& dataset);

}  // namespace jaculus::trajectory
