#include "jaculus/core/installation.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <link.h>

#include <set>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"

namespace jaculus {
namespace {

namespace fs = std::filesystem;

/// The program or shared library that this code is in; empty where the system doesn't tell.
fs::path own_file() {
  Dl_info info;
  link_map* map = nullptr;
  const void* here = JACULUS_VERSION;  // any address of this file
  const int found = ::dladdr1(here, &info, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP);
  if (found != 0 && map != nullptr && *map->l_name != '\0') return map->l_name;
  std::error_code code;
  return fs::read_symlink("/proc/self/exe", code);  // the program itself has no name in the map
}

/// share/jaculus by the place of this code; empty where there is none.
fs::path neighbour_folder() {
  const fs::path own = own_file();
  if (own.empty()) return {};
  std::error_code code;
  const fs::path beside = fs::canonical(own, code).parent_path();
  for (const fs::path& prefix : {beside.parent_path(), beside}) {
    fs::path share = prefix / "share" / "jaculus";
    if (fs::is_directory(share / "models", code)) return share;
  }
  return {};
}

/// Names of the files in problems/ that are no tables.
std::vector<std::string> shipped_names() {
  std::set<std::string> names;
  for (const fs::path& folder : data_folders()) {
    std::error_code code;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder / "problems", code))
      if (entry.path().extension() == ".yaml") names.insert(entry.path().stem().string());
  }
  return {names.begin(), names.end()};
}

}  // namespace

std::string_view version() { return JACULUS_VERSION; }
fs::path source_folder() { return JACULUS_SOURCE_DIR; }
fs::path built_web_folder() { return JACULUS_WEB_DIR; }

fs::path share_folder() {
  static const fs::path neighbour = neighbour_folder();
  return neighbour.empty() ? fs::path(JACULUS_SHARE_DIR) : neighbour;
}

std::vector<fs::path> data_folders() {
  std::vector<fs::path> folders;
  if (!source_folder().empty()) folders.push_back(source_folder());
  folders.push_back(share_folder());
  return folders;
}

fs::path find_problem_file(const std::string& given) {
  const fs::path path = given;
  std::error_code code;
  if (path.has_parent_path() || path.has_extension() || fs::exists(path, code)) return path;

  for (const fs::path& folder : data_folders()) {
    const fs::path shipped = folder / "problems" / (given + ".yaml");
    if (fs::is_regular_file(shipped, code)) return shipped;
  }

  const std::vector<std::string> names = shipped_names();
  throw InputError(
      fmt::format("{}: there is no such file{}; allowed: a file, or the name of one "
                  "that comes with jaculus: {}",
                  given, yaml::did_you_mean(given, names), fmt::join(names, ", ")));
}

}  // namespace jaculus
