#include "cli/robot_xacro.h"

#include <fmt/format.h>

#include <boost/process.hpp>
#include <future>

#include "jaculus/core/error.h"

namespace jaculus::cli {
namespace {

/// The last line that says something.
std::string last_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  const std::size_t at = text.rfind('\n');
  return at == std::string::npos ? text : text.substr(at + 1);
}

}  // namespace

std::string expand_xacro(const std::filesystem::path& file) {
  namespace bp = boost::process;
  if (!std::filesystem::is_regular_file(file))
    throw InputError(fmt::format("{}: not found; allowed: a robot file", file.string()));
  const auto program = bp::search_path("xacro");
  if (program.empty()) {
    throw InputError(fmt::format(
        "{}: a xacro file, which the program xacro expands, and it is not on the PATH; allowed: "
        "`pip install xacro` (or ROS's xacro package), or URDF or MJCF",
        file.string()));
  }

  // both streams are drained while it runs, or it would wait for ever
  boost::asio::io_context streams;
  std::future<std::string> text, errors;
  bp::child child(program, file.string(), bp::std_out > text, bp::std_err > errors,
                  bp::std_in.close(), streams);
  streams.run();
  child.wait();
  if (child.exit_code() != 0)
    throw InputError(
        fmt::format("{}: xacro refuses it: {}", file.string(), last_line(errors.get())));
  return text.get();
}

}  // namespace jaculus::cli
