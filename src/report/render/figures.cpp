// Static figures: the report's data goes to figures.py through a pipe, which draws it with
// matplotlib.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "jaculus/report/report.h"
#include "report/document/json.h"
#include "report/render/assets.h"

namespace jaculus::report {
namespace {

namespace fs = std::filesystem;

constexpr int kNoMatplotlib = 3;  // what figures.py and the probe below exit with

struct Ran {
  int code = -1;
  std::string said;  ///< standard output
};

/// Runs a program with `input` on its standard input and collects what it says.
Ran run(const std::vector<std::string>& command, const std::string& input) {
  int in[2], out[2];
  if (::pipe(in) != 0 || ::pipe(out) != 0)
    throw std::runtime_error(fmt::format("no pipe: {}", std::strerror(errno)));

  std::fflush(nullptr);
  const pid_t writer_for = ::fork();
  if (writer_for < 0) throw std::runtime_error(fmt::format("no process: {}", std::strerror(errno)));
  if (writer_for == 0) {
    ::dup2(in[0], STDIN_FILENO);
    ::dup2(out[1], STDOUT_FILENO);
    for (const int end : {in[0], in[1], out[0], out[1]}) ::close(end);
    std::vector<char*> arguments;
    for (const std::string& a : command) arguments.push_back(const_cast<char*>(a.c_str()));
    arguments.push_back(nullptr);
    ::execvp(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(in[0]);
  ::close(out[1]);

  // a program that ends early is told by its exit code
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  std::size_t written = 0;
  while (written < input.size()) {
    const ssize_t n = ::write(in[1], input.data() + written, input.size() - written);
    if (n <= 0) break;
    written += n;
  }
  ::close(in[1]);
  std::signal(SIGPIPE, before);
  Ran ran;
  char buffer[4096];
  for (ssize_t n = 0; (n = ::read(out[0], buffer, sizeof buffer)) > 0;) ran.said.append(buffer, n);
  ::close(out[0]);
  int status = 0;
  ::waitpid(writer_for, &status, 0);
  ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;

  return ran;
}

/// A python that has matplotlib: the first one of the path, else the system's own, where Debian
/// installs it.
std::string find_python() {
  const std::string probe = fmt::format(
      "import importlib.util, sys; sys.exit(0 if importlib.util.find_spec('matplotlib') else {})",
      kNoMatplotlib);
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    if (run({python, "-c", probe}, "").code == 0) return python;
  }
  throw InputError(
      "--figures: python3 with matplotlib is not installed; allowed: --figures where it is "
      "(Debian: apt-get install "
      "python3-matplotlib), or none");
}

}  // namespace

std::vector<std::string> figure_formats(const std::string& given) {
  static const std::vector<std::string> known{"png", "svg", "pdf"};
  std::vector<std::string> formats;
  std::size_t at = 0;
  while (at <= given.size()) {
    const std::size_t comma = std::min(given.find(',', at), given.size());
    const std::string word = given.substr(at, comma - at);
    if (std::find(known.begin(), known.end(), word) == known.end()) {
      throw InputError(
          fmt::format("--figures: '{}' given; allowed: {}, several with commas between", word,
                      fmt::join(known, ", ")));
    }
    if (std::find(formats.begin(), formats.end(), word) == formats.end()) formats.push_back(word);
    at = comma + 1;
  }
  return formats;
}

void require_figures() { static_cast<void>(find_python()); }

std::vector<fs::path> write_figures(const Report& report, const fs::path& folder,
                                    const std::vector<std::string>& formats) {
  const std::string python = find_python();
  const fs::path target = folder / "figures";
  std::error_code code;
  fs::create_directories(target, code);
  if (code)
    throw InputError(fmt::format("{}: can't be made ({}); allowed: a folder that can be written",
                                 target.string(), code.message()));
  const std::string input =
      document_json(*report.document)
          .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  const Ran ran = run({python, figure_script().string(), target.string(),
                       fmt::format("{}", fmt::join(formats, ","))},
                      input);
  if (ran.code != 0)
    throw std::runtime_error(fmt::format("figures could not be drawn (exit code {})", ran.code));

  std::vector<fs::path> files;
  for (std::size_t at = 0; at < ran.said.size();) {
    const std::size_t end = ran.said.find('\n', at);
    files.emplace_back(ran.said.substr(at, end - at));
    at = end == std::string::npos ? ran.said.size() : end + 1;
  }

  return files;
}

}  // namespace jaculus::report
