#include "core/slurm.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <set>
#include <sstream>

#include "jaculus/core/error.h"
#include "jaculus/core/executor.h"

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX has it in no header

namespace jaculus {
namespace {

struct Said {
  int status = -1;   ///< exit code; -1: could not be run
  std::string text;  ///< standard output and error
};

Said ask(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return {-1, std::strerror(errno)};

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  pid_t child = -1;
  const int fault =
      posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);

  Said said;
  char block[4096];
  for (ssize_t size = 1; fault == 0 && size != 0;) {
    size = read(ends[0], block, sizeof block);
    if (size > 0) said.text.append(block, static_cast<std::size_t>(size));
    if (size < 0 && errno != EINTR) break;
  }
  close(ends[0]);
  if (fault != 0) return {-1, std::strerror(fault)};

  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  said.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return said;
}

}  // namespace

std::vector<std::string> split_options(const std::string& line) {
  std::vector<std::string> words;
  bool within = false;
  char quote = 0;
  for (const char c : line) {
    if (quote == 0 && (c == ' ' || c == '\t' || c == '\n')) {
      within = false;
      continue;
    }
    if (!within) words.emplace_back();
    within = true;
    if (c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
    } else {
      words.back() += c;
    }
  }
  if (quote != 0)
    throw InputError(
        fmt::format("'{}': a quote is not closed; allowed: options as for a shell", line));
  return words;
}

bool detail::ElementState::ended() const {
  static const std::set<std::string> kEnded{"COMPLETED", "CANCELLED",     "FAILED",
                                            "TIMEOUT",   "NODE_FAIL",     "PREEMPTED",
                                            "BOOT_FAIL", "OUT_OF_MEMORY", "DEADLINE"};
  return kEnded.contains(state);
}

std::string detail::submit_array(const Array& array) {
  // Within a job of Slurm, its own variables would pass for the array's.
  std::vector<std::string> words{"env", "-u", "SLURM_CPUS_PER_TASK", "-u", "SLURM_RESTART_COUNT",
                                 "sbatch", "--parsable",
                                 fmt::format("--array=0-{}", array.elements - 1),
                                 "--job-name=" + array.name, "--chdir=" + array.directory.string(),
                                 "--output=" + array.output, "--open-mode=append", "--requeue",
                                 // a minute before its time is over, finished work is left in order
                                 "--signal=B:TERM@60"};
  words.insert(words.end(), array.options.begin(), array.options.end());
  words.push_back(array.script.string());

  const Said said = ask(words);
  std::string id;
  std::istringstream lines(said.text);
  for (std::string line; std::getline(lines, line);)  // messages may stand before it
    if (!line.empty() && line[0] >= '0' && line[0] <= '9') id = line.substr(0, line.find(';'));
  if (said.status == 0 && !id.empty()) return id;
  throw InputError(fmt::format(
      "--executor slurm: sbatch: {}; allowed: a machine from which Slurm takes jobs, and "
      "--slurm-options that it takes",
      said.text.substr(0, said.text.find_last_not_of('\n') + 1)));
}

std::optional<std::map<int, detail::ElementState>> detail::element_states(const std::string& job,
                                                                          std::string* trouble) {
  std::map<int, ElementState> states;
  const Said said = ask({"squeue", "-h", "-r", "-t", "all", "-j", job, "-o", "%K|%T|%r|%N"});
  if (said.status != 0) {
    if (said.text.find("Invalid job id") != std::string::npos) return states;  // long over
    if (trouble != nullptr) *trouble = said.text.substr(0, said.text.find('\n'));
    return std::nullopt;
  }

  std::istringstream lines(said.text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::string element;
    ElementState state;
    std::getline(cells, element, '|');
    std::getline(cells, state.state, '|');
    std::getline(cells, state.reason, '|');
    std::getline(cells, state.node, '|');
    int number = -1;
    const auto [end, code] =
        std::from_chars(element.data(), element.data() + element.size(), number);
    if (code == std::errc() && end == element.data() + element.size()) states[number] = state;
  }
  return states;
}

void detail::cancel_job(const std::string& job) { static_cast<void>(ask({"scancel", job})); }

std::string detail::shell_quoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace jaculus
