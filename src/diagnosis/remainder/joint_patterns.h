#pragma once
// Forms of force at a motor's joint, or at a group of them (place_patterns.h).

#include "diagnosis/remainder/pattern_maker.h"

namespace jaculus::diagnosis {

/// What a group's joints may have as well as one alone.
void add_joint_patterns(PatternMaker& maker);
/// What one joint has: a tight spot, a weight beyond it.
void add_placed_patterns(PatternMaker& maker);

}  // namespace jaculus::diagnosis
