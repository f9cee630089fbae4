#pragma once
// Left and right that part. The model of the plane moves them as one, at the mean of what their
// encoders read, q. What they do together, of sides at q + d and q - d, is
//   (f(q + d) + f(q - d)) / 2 = f(q) + f''(q) d^2 / 2 + ...
// so sides that differ count in the second order only, until they part: in a leap as soon as one
// foot of a pair leaves the floor before the other. Where a log has both sides (channel
// <joint>_apart, their difference 2 d), data from there on are no test of a model of the plane:
// from where the difference began to rise to what it parts by.

#include <optional>

#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::diagnosis {

/// Where a trial's sides first part within [from, to] by more than `limit` [rad or m] beyond what
/// they differ by at its first samples, two samples in a row; nothing where none do, or no log has
/// both. Indices of the dataset stay 0.
std::optional<Parting> first_parting(const trajectory::Trial& trial, double from, double to,
                                     double limit);

/// "trial_01: ...": what was seen and left out, a sentence for a dataset's partings.
std::string note_of(const std::string& dataset, const std::vector<Parting>& partings);

/// By how much the body left the plane at `end` since it stood at `begin` [s], of the channels y,
/// roll and yaw: mean over trials and scatter from one to the next. What repeats tells that left and
/// right differ. Empty where none is tracked.
std::string out_of_plane(const trajectory::Dataset& dataset, const std::string& label, double begin,
                         double end);

}  // namespace jaculus::diagnosis
