#pragma once
// Values that can be meant and hardly are: a slip of the decimal point or of the unit gives numbers
// that every check of kinds and ranges passes.

#include <string>
#include <vector>

#include "jaculus/model/planar.h"

namespace jaculus::model {

/// One sentence for each value that is off what is usual by far: its path, what it is, what is
/// usual, and why.
std::vector<std::string> unusual_values(const PlanarModel& model);

}  // namespace jaculus::model
