#pragma once

#include <stdlib.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>

namespace jaculus::evaluation {

/// A folder for temporary files that nobody else has; gone with this value. std::system_error where
/// none can be made.
class ScratchFolder {
 public:
  /// Named `prefix` and six characters of its own.
  explicit ScratchFolder(const std::string& prefix) {
    std::string name = (std::filesystem::temp_directory_path() / (prefix + "XXXXXX")).string();
    if (::mkdtemp(name.data()) == nullptr)
      throw std::system_error(errno, std::generic_category(), "a temporary folder can't be made");
    path = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;  // what is left behind harms nobody
    std::filesystem::remove_all(path, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::filesystem::path path;
};

}  // namespace jaculus::evaluation
