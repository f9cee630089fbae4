#pragma once
// Forces that acted once: a push, a cable that caught, a hand.
//
// Pulses in the force that the model still lacks (motion_boxes.h) are told from what usually is
// missing by pulses.h, which may follow the friction at the joint and the bodies' weights, and is
// larger in fast motion.

#include <vector>

#include "diagnosis/remainder/motion_boxes.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// Events in the order of dataset, trial and time. `boxes`: motion_boxes() of `all`.
std::vector<ForceEvent> force_events(const Problem& all,
                                     const std::vector<std::vector<MotionBox>>& boxes);

}  // namespace jaculus::diagnosis
