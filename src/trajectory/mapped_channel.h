#pragma once
// One channel of a map of columns or of message fields.

#include <string>

#include "jaculus/trajectory/column_map.h"

namespace jaculus::trajectory {

/// Reads {WORD: text, WORDs: [texts], unit, scale, offset}, where `word` is "column" or "field".
/// Faults: InputError with the node's place.
MappedChannel read_mapped_channel(const std::string& channel, const yaml::Node& node,
                                  const std::string& word);

}  // namespace jaculus::trajectory
