#pragma once
// The robot at telling times: as measured, as predicted, and the force that the nominal model
// lacks.
//
// Times are those at which the robot leaves the nominal model (localise/departure.h), at which the
// error of one segment, root mean square over channels in noise floors, first reaches half of its
// largest value, and at which it is largest. The segment is the first trial, or of windows under a
// logged input the one with the largest error. The measured state is that of windows.h: the judged
// model's own where no sensor and no foot on the floor says otherwise, clocks and starts as that
// model finds them. The force is the mean over
// settings.posture_force of
//   M(q) (v measured - v restarted)/h,   h = settings.force_step (force.h).

#include "diagnosis/forward/plant_forward.h"
#include "diagnosis/noise/noise_model.h"
#include "jaculus/diagnosis/localisation.h"

namespace jaculus::diagnosis {

/// Postures of one segment of the first dataset, rising in time; empty where the nominal model
/// can't be simulated there. `none`, `model`: parameters of the nominal and of the augmented one.
/// `departure`: when the robot leaves the model, where that is known [s].
std::vector<Posture> postures_of(const Problem& problem, const PlantForward& forward,
                                 const NoiseModel& judged, const Vector& none, const Vector& model,
                                 const Departure& departure);

}  // namespace jaculus::diagnosis
