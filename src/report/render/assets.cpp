#include "report/render/assets.h"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

#include "jaculus/core/installation.h"

namespace jaculus::report {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> web_folders() {
  std::vector<fs::path> folders;
  if (const char* given = std::getenv("JACULUS_WEB")) return {fs::path(given)};
  if (!built_web_folder().empty()) folders.push_back(built_web_folder());
  folders.push_back(share_folder() / "web");
  return folders;
}

}  // namespace

std::optional<std::string> web_asset(const std::string& name) {
  for (const fs::path& folder : web_folders()) {
    std::ifstream stream(folder / name, std::ios::binary);
    if (!stream) continue;
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }
  return std::nullopt;
}

fs::path figure_script() {
  std::error_code code;
  const fs::path source = source_folder() / "src/report/render/figures.py";
  const bool in_source = !source_folder().empty() && fs::exists(source, code);
  return in_source ? source : share_folder() / "figures.py";
}

}  // namespace jaculus::report
