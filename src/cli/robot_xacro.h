#pragma once
// xacro files, through ROS's own tool.

#include <filesystem>
#include <string>

namespace jaculus::cli {

/// The URDF that the program `xacro` (ROS's, also on PyPI) makes of a file. InputError where it is
/// not on the PATH, or with its last line where it fails.
std::string expand_xacro(const std::filesystem::path& file);

}  // namespace jaculus::cli
