#pragma once
// Units of a log's columns. A suffix of the name tells the dimension ("_velocity", "_torque", ...),
// as do the names of the base's coordinates; any other name is a joint or a coordinate of its own
// and may have any dimension that a unit is known for.

#include <string>
#include <string_view>
#include <vector>

#include "jaculus/core/units.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::trajectory {

/// What a unit means: SI = factor * given.
struct ChannelUnit {
  double factor = 1.0;
  std::string si;  ///< "rad/s", "-"
};

/// Dimensions that a channel of this name may have, the usual one first.
std::vector<Dimension> channel_dimensions(std::string_view channel);

/// The unit of a column. `place` stands before messages ("joints.csv:1"). None where a dimension
/// needs one, unknown, or of another dimension than the name has: InputError.
ChannelUnit channel_unit(const Column& column, const std::string& place);

/// "front_a_apart", the channel of what two sides differ by, where `count` columns make up a
/// joint's position in `unit` (SI); empty for any other channel, whose mean says it all.
std::string apart_of(const std::string& channel, const std::string& unit, int count);

}  // namespace jaculus::trajectory
