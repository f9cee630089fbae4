#pragma once
// Where jaculus was built and is installed, and which version it is. One source file is told by the
// build; the rest of the library asks here, so that neither a version nor a path recompiles it.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace jaculus {

/// Version of jaculus, as the project in CMakeLists.txt has it.
std::string_view version();

/// The source tree that this library was built from; it may have gone since. Empty in a build that
/// is to know nothing of it, as the Python package's.
std::filesystem::path source_folder();

/// Where the installed program keeps robots, problems and viewers: share/jaculus beside what this
/// code is in (a program in bin/, a Python module) or beside the folder of that, else in the prefix
/// that it was configured for.
std::filesystem::path share_folder();

/// Folders that hold models/, problems/ and effects/, the source tree first.
std::vector<std::filesystem::path> data_folders();

/// Where the build puts the viewers of reports; it may have gone since. Empty as source_folder().
std::filesystem::path built_web_folder();

/// The file of a problem, an experiment or a study as a user names it: a path, or the name of one
/// that comes with jaculus ("leap_tail"). A path comes back as it is, whether a file is there or
/// not. InputError where a name, which has neither folder nor extension, is nothing's.
std::filesystem::path find_problem_file(const std::string& given);

}  // namespace jaculus
