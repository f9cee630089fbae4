#pragma once
// Where jaculus was built and is installed, and which version it is. One source file is told by the
// build; the rest of the library asks here, so that neither a version nor a path recompiles it.

#include <filesystem>
#include <string_view>

namespace jaculus {

/// Version of jaculus, as the project in CMakeLists.txt has it.
std::string_view version();

/// The source tree that this library was built from; it may have gone since.
std::filesystem::path source_folder();

/// Where the installed program keeps robots, problems and viewers.
std::filesystem::path share_folder();

/// Where the build puts the viewers of reports; it may have gone since.
std::filesystem::path built_web_folder();

}  // namespace jaculus
