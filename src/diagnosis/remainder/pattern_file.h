#pragma once
// A pattern as a file of an effect (jaculus-effect/1, effects/user_effect.h).

#include <string>
#include <vector>

#include "diagnosis/remainder/place_patterns.h"

namespace jaculus::diagnosis {

/// A line of `constants`.
std::string constant_line(const std::string& name, const std::string& unit, double value);

/// A line of `parameters`.
std::string parameter_line(const std::string& name, const std::string& unit, double nominal,
                           const Bounds& bounds, double scale);
/// The same of a size found: nothing at nominal, either sign.
std::string size_line(const std::string& name, const std::string& unit, double found);

/// A file of the pattern with these scales; `free_shape`: its period or slack is a parameter.
std::string pattern_file(const PlacePattern& pattern, const std::vector<double>& scales,
                         bool free_shape);

}  // namespace jaculus::diagnosis
