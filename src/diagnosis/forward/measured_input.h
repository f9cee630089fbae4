#pragma once
// A logged input as the command of a segment.

#include "diagnosis/data/observations.h"
#include "jaculus/simulation/controller.h"

namespace jaculus::diagnosis {

/// The logs of every motor that has one (controller.input of the dataset) as one script from the
/// start of `segment` on, linear between samples. Motors whose logs have other stamps are
/// interpolated onto the union of all stamps; before its first and after its last sample a log
/// keeps its end value. `step`: samples are averaged over cells of this time [s]. `late`: the log
/// acts that much later than it is stamped, sooner where negative [s], so that what acts first was
/// logged before the segment began, or after.
simulation::Controller measured_controller(const ObservedDataset& observed, const Segment& segment,
                                           double step, double late = 0.0);

}  // namespace jaculus::diagnosis
