#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace jaculus {

/// More than any text that a person states is no such text.
inline constexpr std::uintmax_t kMaxTextBytes = 10'000'000;

/// All bytes of a regular file of at most kMaxTextBytes. InputError otherwise, saying that
/// `allowed`, as in "a YAML file", is.
std::string read_text_file(const std::filesystem::path& file, const std::string& allowed);

}  // namespace jaculus
