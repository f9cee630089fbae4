#pragma once
// Where the built web assets and scripts of reports stand.

#include <filesystem>
#include <optional>
#include <string>

namespace jaculus::report {

/// The text of a file of the web assets ("report.js"), from JACULUS_WEB (a folder) where that is
/// set, else from the build folder or the installed share folder, in this order; nothing where it
/// isn't there.
std::optional<std::string> web_asset(const std::string& name);

/// The script that draws static figures.
std::filesystem::path figure_script();

}  // namespace jaculus::report
