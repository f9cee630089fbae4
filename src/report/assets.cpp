#include "report/assets.h"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

namespace jaculus {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> web_folders() {
  std::vector<fs::path> folders;
  if (const char* given = std::getenv("JACULUS_WEB")) return {fs::path(given)};
  folders.emplace_back(JACULUS_WEB_DIR);
  folders.emplace_back(fs::path(JACULUS_SHARE_DIR) / "web");
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
  const fs::path source = fs::path(JACULUS_SOURCE_DIR) / "src/report/figures.py";
  return fs::exists(source, code) ? source : fs::path(JACULUS_SHARE_DIR) / "figures.py";
}

}  // namespace jaculus
