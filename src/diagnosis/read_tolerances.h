#pragma once
// Tolerances as users write them, checked against the channels that count as evidence.

#include "diagnosis/data/observations.h"
#include "jaculus/diagnosis/physical.h"

namespace jaculus::diagnosis {

/// The key of a channel in HeldOut::channels: "mocap.x", "dataset.mocap.x" where there are several.
std::string channel_key(const Observations& observations, int dataset, int channel);

/// "CHANNEL=QUANTITY" each. A channel is named as "x", "mocap.x" or "dataset.mocap.x", and stands
/// for all that are so named; "0.005 SI" is in its SI unit. InputError where none is, where the
/// quantity is of another dimension or not positive, or where a channel has two tolerances.
Tolerances read_tolerances(const std::vector<std::string>& texts, const Observations& observations);

}  // namespace jaculus::diagnosis
