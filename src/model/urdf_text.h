#pragma once
// Text of URDF files below the level of elements: hostile nesting, numbers that are nearly numbers,
// shapes.

#include <tinyxml.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/model/urdf.h"
#include "model/assumptions.h"

namespace jaculus::model {

/// The text without bytes 0x00 at its end.
std::string without_padding(const std::string& text, Assumptions& assumptions);

/// tinyxml descends by recursion, so hostile nesting is refused before it is parsed: InputError.
void check_nesting(const std::string& text, const std::filesystem::path& file);

/// How many finite numbers a text is; nothing where a word is none.
std::optional<int> exact_numbers(const std::string& text);

/// `count` numbers of a text whose words begin with numbers ("-1.57."), of the default of a
/// substitution that nobody made ("$(optenv NAME 0.1 0 0)"), or of a longer list. Nothing where
/// there are none.
std::optional<std::string> repair_numbers(const std::string& text, int count);

/// Adds the shape of a <collision>; one that isn't understood is no shape.
void read_shape(const TiXmlElement& collision, std::vector<SpatialShape>& shapes);

}  // namespace jaculus::model
