#pragma once
// The first time at which the mean residual over the trials leaves its band for good, and the onset
// behind it. Formulae in localise.h.

#include <string>
#include <vector>

#include "jaculus/diagnosis/localisation.h"
#include "jaculus/diagnosis/settings.h"

namespace jaculus::diagnosis {

/// Mean residual of one channel over the trials.
struct DepartureChannel {
  std::string name;
  bool rate = false;       ///< a velocity: it grows one power of time earlier than a position
  Vector time;             ///< rising [s]
  Vector mean;             ///< measured - predicted, in the channel's unit
  Vector error;            ///< standard deviation of `mean`, a sample each
  double inflation = 1.0;  ///< samples for one independent one, by autocorrelation, >= 1
};

/// Noise alone leaves the band somewhere with the chance settings.departure_level. `until`: what
/// comes later isn't looked at [s].
Departure first_departure(const std::vector<DepartureChannel>& channels,
                          const Settings& settings = {}, double until = kInfinity);

}  // namespace jaculus::diagnosis
