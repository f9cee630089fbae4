#pragma once
// The authors' recipe (leap_speed.h) on a dataset of leaps, beside what its plan says.

#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/trajectory/dataset.h"
#include "jaculus/trajectory/leap_speed.h"

namespace jaculus::trajectory {

/// The recipe on one trial.
struct TrialSpeed {
  std::string trial;
  std::optional<LeapSpeed> found;  ///< nothing where leap_speed finds none
};

/// The recipe on a dataset of leaps.
struct LeapAccelerations {
  std::vector<TrialSpeed> trials;  ///< those with x by motion capture
  double mean = kNaN;              ///< acceleration over the trials where it was found [m/s^2]
  double plan = kNaN;              ///< the plan's own v/T at its end; NaN without x [m/s^2]
  double duration = kNaN;          ///< T of the plan [s]
};

/// Nothing where the dataset is no leap, has no plan, or no trial has x by motion capture.
std::optional<LeapAccelerations> leap_accelerations(const Dataset& dataset);

}  // namespace jaculus::trajectory
