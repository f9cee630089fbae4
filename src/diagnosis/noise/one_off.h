#pragma once
// What happened to one trial only, and belongs to no effect.

#include <vector>

#include "diagnosis/noise/noise_model.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// Segments (of settings.one_off_fewest or more that a command drove) that leave the others:
/// scatter about the mean over segments, the mean square from a time on at least
/// settings.one_off_excess times the largest of the others', and quiet before it. None where half
/// of the segments differ. Channels of `ignored` don't take part.
std::vector<OneOff> one_off_disturbances(const Problem& problem, const NoiseModel& noise,
                                         const std::vector<ChannelPlace>& ignored = {});

}  // namespace jaculus::diagnosis
