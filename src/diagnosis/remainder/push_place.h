#pragma once
// A push that every trial had, as what is left at a place: it follows the time since the start.

#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/model/planar.h"

namespace jaculus::diagnosis {

/// Where a push acted, with the file of an effect (jaculus-effect/1) that is it: of time t a half
/// sine
///   F(t) = peak sin(pi s),  s = (t - start)/length within [0, 1],
/// whose start and length are free. Which share of the gap it takes is left open.
RemainderPlace push_place(const ForceEvent& push, const model::PlanarModel& robot);

}  // namespace jaculus::diagnosis
