#include "core/isolate.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "jaculus/core/interrupt.h"

namespace jaculus::detail {
namespace {

bool isolated_child = false;

// Between pipe() and the parent's close of the writing end no other thread may fork: its child
// would hold that end open, and the reader would wait for a child that is not its own.
std::mutex fork_mutex;
// guarded by fork_mutex; children close what belongs to their siblings
std::vector<int> open_readers;

struct Child {
  pid_t pid = -1;
  int reader = -1;
};

/// First byte of what a child sends: how it ended. Without one it crashed.
constexpr char kReturned = 'R';
constexpr char kThrew = 'T';

void send(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) _exit(3);
    bytes.remove_prefix(written);
  }
}

[[noreturn]] void run_child(const std::function<std::string()>& job,
                            const std::function<void()>& in_child, int writer, pid_t parent) {
  isolated_child = true;
  signal(SIGINT, SIG_IGN);  // Ctrl-C reaches the whole group; only the parent decides what ends
  signal(SIGTERM, SIG_DFL);
  clear_interrupt();  // a signal between fork and here was the parent's as well
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(4);  // the parent died before the line above

  char tag = kReturned;
  std::string bytes;
  try {
    in_child();
    bytes = job();
  } catch (const std::exception& error) {
    tag = kThrew;
    bytes = error.what();
  } catch (...) {
    tag = kThrew;
    bytes = "an exception that is not a std::exception";
  }

  send(writer, std::string_view(&tag, 1));
  send(writer, bytes);
  // at the end: a child that dies while sending is noticed
  const std::uint64_t length = bytes.size();
  send(writer, std::string_view(reinterpret_cast<const char*>(&length), sizeof length));
  _exit(0);  // without flushing streams that were copied from the parent
}

Child start_child(const std::function<std::string()>& job, const std::function<void()>& in_child) {
  std::unique_lock lock(fork_mutex);
  const pid_t parent = getpid();
  int ends[2];
  if (pipe(ends) != 0) return {};

  const pid_t pid = fork();
  if (pid == 0) {
    close(ends[0]);
    for (const int reader : open_readers) close(reader);
    open_readers.clear();
    lock.unlock();  // the copy of the lock came locked; the child may start children of its own
    run_child(job, in_child, ends[1], parent);
  }

  close(ends[1]);
  if (pid < 0) {
    close(ends[0]);
    return {};
  }

  open_readers.push_back(ends[0]);
  return {pid, ends[0]};
}

enum class Ending { closed, interrupted, out_of_time };

/// Reads until the child closes its end, looking at the interrupt flag and the clock.
Ending receive(int reader, double time_limit_s, std::string& bytes) {
  const auto begin = std::chrono::steady_clock::now();
  char buffer[1 << 16];
  for (;;) {
    if (interrupt_requested()) return Ending::interrupted;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (elapsed.count() > time_limit_s) return Ending::out_of_time;
    const double wait_s = std::clamp(time_limit_s - elapsed.count(), 0.0, 0.05);
    pollfd watch{reader, POLLIN, 0};
    if (poll(&watch, 1, 1 + static_cast<int>(1e3 * wait_s)) <= 0) continue;
    const ssize_t size = read(reader, buffer, sizeof buffer);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return Ending::closed;
    bytes.append(buffer, size);
  }
}

/// Ends the child where it still runs and returns its wait status.
int reap(const Child& child, bool kill_it) {
  if (kill_it) kill(child.pid, SIGKILL);
  int status = 0;
  while (waitpid(child.pid, &status, 0) < 0 && errno == EINTR) {
  }
  const std::lock_guard lock(fork_mutex);
  std::erase(open_readers, child.reader);
  close(child.reader);
  return status;
}

/// Whether a child that a signal ended fell with its parent. Who ends a whole group (Slurm does)
/// may reach the child first.
bool fell_with_parent(int status) {
  if (!WIFSIGNALED(status)) return false;
  for (int wait = 0; wait < 20 && WTERMSIG(status) == SIGTERM && !interrupt_requested(); ++wait)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return interrupt_requested();
}

TaskResult failure(std::string error) { return {TaskState::failed, "", std::move(error), false}; }

TaskResult unpack(const std::string& sent, int status) {
  std::uint64_t length = 0;
  const bool whole = sent.size() > sizeof length;
  if (whole) std::memcpy(&length, sent.data() + sent.size() - sizeof length, sizeof length);
  if (WIFSIGNALED(status)) {
    return failure(
        fmt::format("ended by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status))));
  }
  if (!whole || length != sent.size() - 1 - sizeof length || WEXITSTATUS(status) != 0) {
    return failure(fmt::format("ended without a result, exit code {}", WEXITSTATUS(status)));
  }
  std::string bytes = sent.substr(1, length);
  if (sent[0] == kThrew) return failure(std::move(bytes));
  return {TaskState::done, std::move(bytes), "", false};
}

}  // namespace

bool is_isolated_child() { return isolated_child; }

TaskResult run_isolated(const std::function<std::string()>& job, double time_limit_s,
                        const std::function<void()>& in_child) {
  const Child child = start_child(job, in_child);
  if (child.pid < 0) return failure(std::string("can't start a process: ") + std::strerror(errno));
  std::string sent;
  const Ending ending = receive(child.reader, time_limit_s, sent);
  const int status = reap(child, ending != Ending::closed);
  if (ending == Ending::interrupted) return {};
  if (ending == Ending::closed && fell_with_parent(status)) return {};
  if (ending == Ending::out_of_time)
    return failure(fmt::format("not finished within {:g} s", time_limit_s));
  return unpack(sent, status);
}

}  // namespace jaculus::detail
