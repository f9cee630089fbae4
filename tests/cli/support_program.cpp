#include <fcntl.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

#include "cli/program.h"
#include "support/temporary_folder.h"

namespace jaculus::test {

namespace {

/// The built one, or that of the environment: a wheel's.
const char* program() {
  const char* given = std::getenv("JACULUS_PROGRAM");
  return given != nullptr && *given != '\0' ? given : JACULUS_BINARY;
}

std::vector<char*> argument_vector(const std::vector<std::string>& arguments) {
  std::vector<char*> argv = {const_cast<char*>(program())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  return argv;
}

int exit_code_of(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

Outcome run_program(const std::vector<std::string>& arguments, const std::string& folder) {
  // Files instead of pipes: a child that writes much can't block.
  const TemporaryFolder scratch;
  const std::string out = scratch / "out";
  const std::string err = scratch / "err";
  std::vector<char*> argv = argument_vector(arguments);
  const pid_t child = ::fork();
  if (child == 0) {
    const int out_file = ::open(out.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
    const int err_file = ::open(err.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
    ::dup2(out_file, STDOUT_FILENO);
    ::dup2(err_file, STDERR_FILENO);
    if (!folder.empty() && ::chdir(folder.c_str()) != 0) ::_exit(126);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  const int code = exit_code_of(child);
  return {code, bytes_of(out), bytes_of(err)};
}

Outcome run_on_terminal(const std::vector<std::string>& arguments, Output output) {
  const TemporaryFolder scratch;
  std::array<int, 2> piped{-1, -1};
  if (output == Output::pipe && ::pipe(piped.data()) != 0) return {};
  const std::string out = scratch / "out";
  std::vector<char*> argv = argument_vector(arguments);
  int ours = -1, theirs = -1;
  if (::openpty(&ours, &theirs, nullptr, nullptr, nullptr) != 0) return {};
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ours);
    const bool into_pipe = output == Output::pipe;
    ::dup2(into_pipe ? piped[1] : ::open(out.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600),
           STDOUT_FILENO);
    if (into_pipe) ::close(piped[0]);
    ::dup2(theirs, STDERR_FILENO);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  ::close(theirs);
  Outcome outcome;
  std::array<char, 4096> chunk{};
  // Reading fails once the child, the terminal's last user, has gone.
  for (ssize_t got = 0; (got = ::read(ours, chunk.data(), chunk.size())) > 0;)
    outcome.err.append(chunk.data(), got);
  ::close(ours);
  outcome.exit_code = exit_code_of(child);
  if (output == Output::file) {
    outcome.out = bytes_of(out);
    return outcome;
  }

  ::close(piped[1]);
  for (ssize_t got = 0; (got = ::read(piped[0], chunk.data(), chunk.size())) > 0;)
    outcome.out.append(chunk.data(), got);
  ::close(piped[0]);
  return outcome;
}

}  // namespace jaculus::test
