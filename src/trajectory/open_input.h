#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

namespace jaculus::trajectory {

/// `file` opened to be read byte by byte. Where there is none, a folder or no leave to read:
/// InputError; `expected` says there what the file should be, as in "a CSV file".
std::ifstream open_input(const std::filesystem::path& file, std::string_view expected);

}  // namespace jaculus::trajectory
