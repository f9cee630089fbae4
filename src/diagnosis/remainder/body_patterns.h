#pragma once
// Forms of force on the body and at feet (place_patterns.h).

#include <string>

#include "diagnosis/remainder/pattern_maker.h"

namespace jaculus::diagnosis {

/// `axis`: "x" or "z".
void add_body_patterns(PatternMaker& maker, const std::string& axis);
void add_moment_patterns(PatternMaker& maker);
void add_foot_patterns(PatternMaker& maker);

}  // namespace jaculus::diagnosis
