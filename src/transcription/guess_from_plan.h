#pragma once
// A guess from an earlier plan: phases are matched by their number, coordinates and motors by name.

#include "jaculus/trajectory/trajectory.h"
#include "jaculus/transcription/layout.h"

namespace jaculus::transcription {

/// Copies into x [columns] what the earlier plan has: samples at the same fraction of the phase of
/// the same number. What it lacks stays as it is.
void copy_plan(const trajectory::Trajectory& earlier, const Layout& layout,
               const model::PlanarModel& model, Vector& x);

}  // namespace jaculus::transcription
