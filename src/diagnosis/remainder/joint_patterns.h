#pragma once
// Forms of force at a motor's joint, or at a group of them (place_patterns.h).

#include "diagnosis/remainder/pattern_maker.h"

namespace jaculus::diagnosis {

/// What a group's joints may have as well as one alone, and of one what goes with its own angle.
void add_joint_patterns(PatternMaker& maker);

}  // namespace jaculus::diagnosis
