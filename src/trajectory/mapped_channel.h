#pragma once
// The channels of a map of columns or of message fields.

#include <string>
#include <vector>

#include "jaculus/trajectory/column_map.h"

namespace jaculus::trajectory {

/// Reads {NAME: {WORD: text, WORDs: [texts], unit, scale, offset}, ...}; `word` is "column" or
/// "field". Faults: InputError with the node's place.
std::vector<MappedChannel> read_mapped_channels(const yaml::Node& node, const std::string& word);

}  // namespace jaculus::trajectory
