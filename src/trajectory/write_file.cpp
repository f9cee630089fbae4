#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include "jaculus/core/error.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::trajectory {
namespace {

InputError unwritable(const std::filesystem::path& file, const std::string& why) {
  return InputError(fmt::format("{}: can't be written: {}", file.string(), why));
}

/// Returns why it failed, or nothing.
std::string write_in_place(const std::filesystem::path& file,
                           const std::function<std::string()>& piece) {
  errno = 0;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  for (std::string text = piece(); stream && !text.empty(); text = piece())
    stream.write(text.data(), text.size());
  stream.close();
  const int reason = errno;
  if (stream) return "";
  return reason != 0 ? std::strerror(reason) : "the stream failed";
}

}  // namespace

void write_file(const std::filesystem::path& file, const std::string& text) {
  bool given = false;
  write_file(file, [&] { return std::exchange(given, true) ? std::string() : text; });
}

void write_file(const std::filesystem::path& file, const std::function<std::string()>& piece) {
  std::error_code code;
  const auto status = std::filesystem::status(file, code);  // follows links
  if (std::filesystem::is_directory(status)) throw unwritable(file, "it is a folder");
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    if (const std::string why = write_in_place(file, piece); !why.empty())
      throw unwritable(file, why);
    return;
  }
  // A link keeps pointing at its file: the neighbour of what it points to is the one that is
  // renamed.
  const std::filesystem::path target = std::filesystem::is_symlink(file, code)
                                           ? std::filesystem::weakly_canonical(file, code)
                                           : file;

  // The name is unique among the threads of this process and among processes; no fsync, for a kill
  // does not need it.
  static std::atomic<unsigned> counter{0};
  std::filesystem::path temporary = target;
  temporary.replace_filename(
      fmt::format(".{}.{}-{}.part", target.filename().string(), ::getpid(), counter++));
  std::string why = write_in_place(temporary, piece);
  if (why.empty()) {
    std::filesystem::rename(temporary, target, code);
    if (!code) return;
    why = code.message();
  }
  std::filesystem::remove(temporary, code);
  throw unwritable(file, why);
}

}  // namespace jaculus::trajectory
