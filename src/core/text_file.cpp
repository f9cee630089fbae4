#include "core/text_file.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <system_error>

#include "jaculus/core/error.h"

namespace jaculus {

std::string read_text_file(const std::filesystem::path& file, const std::string& allowed) {
  const auto refuse = [&file](const std::string& what) {
    return InputError({.file = file.string()}, what);
  };

  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(file, code);
  if (!std::filesystem::exists(status)) throw refuse("file not found; allowed: " + allowed);
  if (std::filesystem::is_directory(status)) throw refuse("is a folder; allowed: " + allowed);
  if (!std::filesystem::is_regular_file(status))
    throw refuse("is no regular file; allowed: " + allowed);

  const std::uintmax_t size = std::filesystem::file_size(file, code);
  if (code) throw refuse("can't be read: " + code.message());
  if (size > kMaxTextBytes)
    throw refuse(fmt::format("holds {} bytes; allowed: at most {}", size, kMaxTextBytes));

  std::ifstream stream(file, std::ios::binary);
  std::stringstream text;
  if (size > 0) text << stream.rdbuf();
  if (!stream || !text)
    throw refuse("can't be read; allowed: a readable " + allowed.substr(allowed.find(' ') + 1));

  return text.str();
}

}  // namespace jaculus
