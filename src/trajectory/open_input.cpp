#include "trajectory/open_input.h"

#include <fmt/format.h>

#include <system_error>

#include "jaculus/core/error.h"

namespace jaculus::trajectory {

std::ifstream open_input(const std::filesystem::path& file, std::string_view expected) {
  std::error_code code;
  if (!std::filesystem::exists(file, code))
    throw InputError({.file = file.string()}, "there is no such file");
  if (std::filesystem::is_directory(file, code))
    throw InputError(fmt::format("{}: a folder; {} is expected", file.string(), expected));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("{}: can't be read", file.string()));
  return stream;
}

}  // namespace jaculus::trajectory
