#include "evaluation/run_diagnosis.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>
#include <thread>

#include "evaluation/scratch_folder.h"
#include "jaculus/core/error.h"
#include "jaculus/testbed/blinded_cases.h"

namespace jaculus::evaluation {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// What a diagnosis needs of the environment; keys and labels never stand in these.
std::vector<std::string> environment() {
  std::vector<std::string> kept;
  for (const char* name : {"PATH", "LANG", "LC_ALL", "TMPDIR", "JACULUS_MODELS"}) {
    if (const char* value = std::getenv(name)) kept.push_back(std::string(name) + "=" + value);
  }
  return kept;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

/// In the child: into the folder, output to a file, nothing else open, then the program. Does not
/// return.
[[noreturn]] void become(const fs::path& folder, const fs::path& log, char* const* arguments,
                         char* const* variables, pid_t parent) {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(126);
#else
  (void)parent;
#endif
  const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int in = ::open("/dev/null", O_RDONLY);
  if (out < 0 || in < 0 || ::chdir(folder.c_str()) != 0) ::_exit(126);
  ::dup2(in, 0);
  ::dup2(out, 1);
  ::dup2(out, 2);
  for (int descriptor = 3; descriptor < 256; ++descriptor) ::close(descriptor);
  ::execve(arguments[0], arguments, variables);
  ::_exit(127);
}

/// Exit status as waitpid gives it, or nothing where time ran out and the program was ended.
std::optional<int> wait_for(pid_t child, double time_limit_s) {
  const auto start = Clock::now();
  for (;;) {
    int status = 0;
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) return status;
    if (ended < 0 && errno != EINTR) return 126 << 8;
    if (std::chrono::duration<double>(Clock::now() - start).count() > time_limit_s) {
      ::kill(child, SIGKILL);
      ::waitpid(child, &status, 0);
      return std::nullopt;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

std::string last_line(const fs::path& file) {
  std::ifstream stream(file);
  std::string line, last;
  while (std::getline(stream, line)) {
    if (!line.empty()) last = line;
  }
  return last;
}

Prediction failed(const std::string& why) {
  Prediction prediction;
  prediction.message = why;
  return prediction;
}

void keep(const fs::path& from, const fs::path& folder) {
  std::error_code ignored;  // a file that the program did not write
  fs::copy_file(from, folder / from.filename(), fs::copy_options::overwrite_existing, ignored);
}

Prediction run_in(const ScratchFolder& scratch, const DiagnosisRun& run) {
  const fs::path log = scratch.path / "messages.txt", predictions = scratch.path / "answer";
  std::vector<std::string> arguments = {fs::absolute(run.binary).string(), "diagnose"};
  for (const fs::path& dataset : testbed::case_datasets(run.dataset)) {
    arguments.push_back(dataset == run.dataset ? "dataset" : dataset.filename().string());
    fs::copy(dataset, scratch.path / arguments.back(), fs::copy_options::recursive);
  }
  for (const std::string& flag :
       {std::string("--out"), std::string("answer"), std::string("--seed"),
        std::to_string(run.seed), std::string("--jobs"), std::string("1"), std::string("--quiet")})
    arguments.push_back(flag);
  arguments.insert(arguments.end(), run.flags.begin(), run.flags.end());
  std::vector<std::string> variables = environment();
  const std::vector<char*> argv = pointers(arguments), envp = pointers(variables);
  const auto start = Clock::now();
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) return failed("no process could be started");
  if (child == 0) become(scratch.path, log, argv.data(), envp.data(), parent);

  const std::optional<int> status = wait_for(child, run.time_limit_s);
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  for (const fs::path& file : {predictions / "diagnosis.json", predictions / "augmented.yaml", log})
    keep(file, run.keep);
  if (!status) return failed(fmt::format("no answer within {} s", run.time_limit_s));
  if (!WIFEXITED(*status)) return failed(fmt::format("ended by signal {}", WTERMSIG(*status)));
  if (WEXITSTATUS(*status) > 1)
    return failed(fmt::format("exit code {}: {}", WEXITSTATUS(*status), last_line(log)));

  Prediction prediction = read_prediction(predictions / "diagnosis.json");
  prediction.seconds = seconds;
  return prediction;
}

}  // namespace

Prediction run_diagnosis(const DiagnosisRun& run) {
  try {
    fs::create_directories(run.keep);
    const ScratchFolder scratch("jaculus_case_");
    return run_in(scratch, run);
  } catch (const std::exception& error) {
    return failed(error.what());
  }
}

}  // namespace jaculus::evaluation
