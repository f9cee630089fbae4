#pragma once
// Which channels of a dataset count as evidence.

#include <string>
#include <vector>

#include "diagnosis/data/observations.h"

namespace jaculus::diagnosis {

/// Sets streams and channels of `observed` to those of its dataset that the plant predicts and that
/// are no command; the others are noted. `label` opens the notes.
void select_channels(ObservedDataset& observed, const std::string& label,
                     std::vector<std::string>& notes);

}  // namespace jaculus::diagnosis
