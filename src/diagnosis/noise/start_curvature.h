#pragma once
// What a segment's start does beyond its slopes: a foot that slips in one trial alone makes starts
// of some mrad act in jumps.
//   s: start offsets of a segment by its nuisances on the rows of its prefix (nuisances.h)
//   curvature = f(p; s) - f(p; 0) - A_s s,   taken off the segment's recorded values, so that
//   everything else stays linear in starts.
// Starts that the prefix does not tell stay near zero and so does their curvature.

#include <optional>
#include <vector>

#include "diagnosis/noise/channel_noise.h"
#include "diagnosis/noise/nuisances.h"

namespace jaculus::diagnosis {

/// The alignment with the curvature taken off its values; nothing where no segment changes (no
/// starts, or a logged input). `p`: the point about which `predictions` are.
std::optional<Alignment> without_start_curvature(const Problem& problem, const Vector& p,
                                                 int dataset,
                                                 const std::vector<const Prediction*>& predictions,
                                                 const std::vector<SegmentNuisances>& nuisances,
                                                 const std::vector<ChannelNoise>& channels,
                                                 const Alignment& alignment);

}  // namespace jaculus::diagnosis
