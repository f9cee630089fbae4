#pragma once
// Units as other programs write them.

#include <optional>
#include <string>
#include <string_view>

namespace jaculus {

/// "N mm" of "Nmm": two units without what parts them. Nothing where the text is no such pair.
std::optional<std::string> parted_unit(std::string_view unit);

}  // namespace jaculus
