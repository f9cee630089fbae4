#include "jaculus/core/tasks.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>

#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/journal.h"

namespace jaculus {
namespace {

namespace fs = std::filesystem;

class TempFolder {
 public:
  TempFolder() {
    std::string name = (fs::temp_directory_path() / "jaculus_tasks_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TempFolder() { fs::remove_all(path_); }
  fs::path operator/(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

/// Some bytes that depend on the index alone, zeros among them.
std::string answer(int index) {
  std::string bytes;
  std::uint64_t state = task_seed(7, static_cast<std::uint64_t>(index));
  for (int i = 0; i < 40 + 10 * index; ++i) {
    state = task_seed(state, 0);
    bytes.push_back(static_cast<char>(state & 0x3f));
  }
  return bytes;
}

std::string read_bytes(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void write_bytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

TEST(Tasks, ResultsAreInTaskOrderWhateverTheWorkers) {
  for (const bool isolate : {false, true}) {
    for (const int workers : {0, 1, 2, 5}) {
      const auto results =
          run_tasks(17,
                    [](int i) {
                      std::this_thread::sleep_for(std::chrono::milliseconds((i * 7) % 5));
                      return answer(i);
                    },
                    {.workers = workers, .isolate = isolate});
      ASSERT_EQ(results.size(), 17u);
      for (int i = 0; i < 17; ++i) {
        EXPECT_EQ(results[i].state, TaskState::done);
        EXPECT_EQ(results[i].bytes, answer(i));
      }
    }
  }
}

TEST(Tasks, NoTasks) { EXPECT_TRUE(run_tasks(0, answer).empty()); }

TEST(Tasks, WorkersRunAtOnce) {
  using Counter = std::atomic<int>;
  void* shared =
      mmap(nullptr, sizeof(Counter), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  auto* arrived = new (shared) Counter(0);
  const auto results = run_tasks(6,
                                 [arrived](int) {
                                   ++*arrived;
                                   // One after the other the first would wait for the rest in vain.
                                   for (int i = 0; i < 4000 && *arrived < 6; ++i)
                                     std::this_thread::sleep_for(std::chrono::milliseconds(5));
                                   return std::to_string(*arrived);
                                 },
                                 {.workers = 6});
  for (const TaskResult& result : results) EXPECT_EQ(result.bytes, "6");
  munmap(shared, sizeof(Counter));
}

TEST(Tasks, LargeAndEmptyResultsComeThroughThePipe) {
  const auto results =
      run_tasks(2, [](int i) { return i == 0 ? std::string() : std::string(5'000'000, 'x'); });
  EXPECT_EQ(results[0].state, TaskState::done);
  EXPECT_EQ(results[0].bytes, "");
  EXPECT_EQ(results[1].bytes, std::string(5'000'000, 'x'));
}

TEST(Tasks, ExceptionsAndCrashesAreTheTasksOwn) {
  const auto results = run_tasks(6,
                                 [](int i) -> std::string {
                                   if (i == 1) throw std::runtime_error("out of luck");
                                   if (i == 2) std::abort();
                                   if (i == 3) {
                                     // a sanitizer would make an exit code of it
                                     signal(SIGSEGV, SIG_DFL);
                                     raise(SIGSEGV);
                                   }
                                   if (i == 4) _exit(0);
                                   return answer(i);
                                 },
                                 {.workers = 3});
  EXPECT_EQ(results[0].bytes, answer(0));
  EXPECT_EQ(results[1].state, TaskState::failed);
  EXPECT_EQ(results[1].error, "out of luck");
  EXPECT_EQ(results[2].state, TaskState::failed);
  EXPECT_NE(results[2].error.find("signal 6"), std::string::npos) << results[2].error;
  EXPECT_NE(results[3].error.find("signal 11"), std::string::npos) << results[3].error;
  EXPECT_NE(results[4].error.find("without a result"), std::string::npos) << results[4].error;
  EXPECT_EQ(results[5].bytes, answer(5));
}

TEST(Tasks, ExceptionsInSharedProcess) {
  const auto results = run_tasks(3,
                                 [](int i) -> std::string {
                                   if (i == 1) throw std::runtime_error("out of luck");
                                   return answer(i);
                                 },
                                 {.isolate = false});
  EXPECT_EQ(results[1].state, TaskState::failed);
  EXPECT_EQ(results[1].error, "out of luck");
  EXPECT_EQ(results[2].bytes, answer(2));
}

TEST(Tasks, IsolatedSideEffectsStayInTheChild) {
  int counter = 0;
  run_tasks(3, [&](int) { return std::to_string(++counter); });
  EXPECT_EQ(counter, 0);
}

TEST(Tasks, TimeLimitEndsAHangingTask) {
  const auto results = run_tasks(2,
                                 [](int i) {
                                   while (i == 0)
                                     std::this_thread::sleep_for(std::chrono::seconds(1));
                                   return answer(i);
                                 },
                                 {.workers = 2, .time_limit_s = 2.0});
  EXPECT_EQ(results[0].state, TaskState::failed);
  EXPECT_NE(results[0].error.find("2 s"), std::string::npos) << results[0].error;
  EXPECT_EQ(results[1].bytes, answer(1));
}

TEST(Tasks, TasksMayRunTasks) {
  const auto results =
      run_tasks(4,
                [](int i) {
                  std::string all;
                  for (const TaskResult& inner : run_tasks(3, [i](int j) { return answer(i + j); }))
                    all += inner.bytes;
                  return all;
                },
                {.workers = 2});
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(results[i].bytes, answer(i) + answer(i + 1) + answer(i + 2));
  }
}

TEST(Tasks, ProgressCountsEveryTask) {
  std::vector<TaskProgress> seen;
  run_tasks(5, answer,
            {.workers = 2, .progress = [&](const TaskProgress& p) { seen.push_back(p); }});
  ASSERT_EQ(seen.size(), 5u);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(seen[i].done, i + 1);
  EXPECT_EQ(seen.back().total, 5);
  EXPECT_EQ(seen.back().remaining_s, 0.0);
  EXPECT_GT(seen.front().remaining_s, 0.0);
}

TEST(Tasks, InterruptKeepsWhatIsFinished) {
  const TempFolder folder;
  for (const bool isolate : {true, false}) {
    const fs::path journal = folder / (isolate ? "a" : "b");
    TaskOptions options{.workers = 1, .isolate = isolate, .journal = journal};
    options.progress = [](const TaskProgress& p) {
      if (p.done == 3) request_interrupt();
    };
    auto results = run_tasks(6, answer, options);
    clear_interrupt();
    EXPECT_EQ(results[2].bytes, answer(2));
    EXPECT_EQ(results[3].state, TaskState::cancelled);
    EXPECT_EQ(results[5].state, TaskState::cancelled);
    options.progress = nullptr;
    results = run_tasks(6, answer, options);
    EXPECT_TRUE(results[2].resumed);
    EXPECT_FALSE(results[3].resumed);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(results[i].bytes, answer(i));
  }
}

TEST(Tasks, InterruptEndsRunningChildrenSoon) {
  const auto begin = std::chrono::steady_clock::now();
  std::thread signaller([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    request_interrupt();
  });
  const auto results = run_tasks(4,
                                 [](int) {
                                   std::this_thread::sleep_for(std::chrono::seconds(20));
                                   return std::string();
                                 },
                                 {.workers = 2});
  signaller.join();
  clear_interrupt();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(elapsed.count(), 5.0);
  for (const TaskResult& result : results) EXPECT_EQ(result.state, TaskState::cancelled);
}

TEST(Tasks, HandlerRaisesTheFlag) {
  install_interrupt_handler();
  EXPECT_FALSE(interrupt_requested());
  raise(SIGTERM);
  EXPECT_TRUE(interrupt_requested());
  clear_interrupt();
  signal(SIGINT, SIG_DFL);
  signal(SIGTERM, SIG_DFL);
}

TEST(Tasks, AScopeTakesInterruptsAndGivesThemBack) {
  static int taken;  // by the handler that the scope finds
  taken = 0;
  signal(SIGINT, [](int) { ++taken; });
  {
    const InterruptScope scope;
    EXPECT_NO_THROW(stop_if_interrupted());
    raise(SIGINT);
    raise(SIGINT);
    EXPECT_TRUE(interrupt_requested());
    EXPECT_THROW(stop_if_interrupted(), Interrupted);
  }
  EXPECT_FALSE(interrupt_requested());
  EXPECT_EQ(taken, 0);

  raise(SIGINT);
  EXPECT_EQ(taken, 1);

  signal(SIGINT, SIG_IGN);
  {
    const InterruptScope scope;
    raise(SIGINT);
    EXPECT_FALSE(interrupt_requested());
  }
  signal(SIGINT, SIG_DFL);
}

TEST(Tasks, FailedTasksRunAgainOnResume) {
  const TempFolder folder;
  TaskOptions options{.isolate = false, .journal = folder / "journal"};
  bool broken = true;
  std::atomic<int> runs = 0;
  const auto task = [&](int i) {
    ++runs;
    if (broken && i == 1) throw std::runtime_error("not today");
    return answer(i);
  };
  EXPECT_EQ(run_tasks(3, task, options)[1].state, TaskState::failed);
  broken = false;
  const auto results = run_tasks(3, task, options);
  EXPECT_EQ(results[1].bytes, answer(1));
  EXPECT_EQ(runs, 4);
}

TEST(Tasks, APartCanBeRunFirstAndTheRestLater) {
  const TempFolder folder;
  TaskOptions options{.isolate = false, .journal = folder / "journal"};
  options.until = 2;
  int total = 0;
  options.progress = [&](const TaskProgress& p) { total = p.total; };
  auto results = run_tasks(4, answer, options);
  EXPECT_EQ(total, 2);
  EXPECT_EQ(results[1].bytes, answer(1));
  EXPECT_EQ(results[2].state, TaskState::cancelled);

  options.until = 9;  // more than there are
  results = run_tasks(4, answer, options);
  EXPECT_TRUE(results[1].resumed);
  EXPECT_FALSE(results[2].resumed);
  EXPECT_EQ(results[3].bytes, answer(3));
}

TEST(Journal, RefusesAnotherListOfTasks) {
  const TempFolder folder;
  TaskOptions options{.journal = folder / "journal", .fingerprint = "a"};
  run_tasks(3, answer, options);
  EXPECT_THROW(run_tasks(4, answer, options), InputError);
  options.fingerprint = "b";
  EXPECT_THROW(run_tasks(3, answer, options), InputError);
  write_bytes(folder / "other", "time [s], x [m]\n0, 0\n");
  options.journal = folder / "other";
  EXPECT_THROW(run_tasks(3, answer, options), InputError);
  EXPECT_EQ(read_bytes(folder / "other"), "time [s], x [m]\n0, 0\n");
}

TEST(Journal, IsLocked) {
  const TempFolder folder;
  const Journal first(folder / "journal", "key");
  EXPECT_THROW(Journal(folder / "journal", "key"), InputError);
}

TEST(Journal, EveryTornTailIsCutOff) {
  const TempFolder folder;
  {
    Journal journal(folder / "whole", "key");
    for (int i = 0; i < 3; ++i) journal.append(i, answer(i));
  }
  const std::string whole = read_bytes(folder / "whole");
  const std::size_t record = 24;  // index, length and check around a payload
  const std::size_t header =
      whole.size() - 3 * record - answer(0).size() - answer(1).size() - answer(2).size();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_bytes(folder / "torn", whole.substr(0, size));
    const JournalContent content = read_journal(folder / "torn");
    std::size_t expected = 0;
    for (std::size_t end = header + record + answer(0).size(); end <= size;
         end += record + answer(static_cast<int>(expected)).size()) {
      ++expected;
    }
    ASSERT_EQ(content.finished.size(), expected) << size;
    ASSERT_EQ(content.has_header, size >= header) << size;
    ASSERT_EQ(content.good_bytes + content.torn_bytes, size);
    Journal journal(folder / "torn", "key");
    journal.append(2, answer(2));
    ASSERT_EQ(read_journal(folder / "torn").finished.at(2), answer(2));
    ASSERT_EQ(read_journal(folder / "torn").torn_bytes, 0u);
  }
}

TEST(Journal, ADamagedRecordIsNoResult) {
  const TempFolder folder;
  {
    Journal journal(folder / "journal", "key");
    for (int i = 0; i < 2; ++i) journal.append(i, answer(i));
  }
  const std::string whole = read_bytes(folder / "journal");
  for (std::size_t at = whole.size() - answer(1).size() - 24; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    write_bytes(folder / "damaged", damaged);
    const JournalContent content = read_journal(folder / "damaged");
    EXPECT_EQ(content.finished.size(), 1u) << at;
    EXPECT_GT(content.torn_bytes, 0u);
  }
}

// The run that the next test kills, in a process of its own: every execution of a task leaves a
// mark.
constexpr int kKilledTasks = 120;
TEST(TasksHelper, DISABLED_JournalledRun) {
  const char* text = std::getenv("JACULUS_TEST_FOLDER");
  ASSERT_NE(text, nullptr);
  const fs::path folder = text;
  const auto results =
      run_tasks(kKilledTasks,
                [&](int i) {
                  std::ofstream(folder / "executed", std::ios::app) << i << '\n';
                  std::this_thread::sleep_for(std::chrono::milliseconds(5 + i % 7));
                  return answer(i);
                },
                {.workers = 2, .journal = folder / "journal", .fingerprint = "killed"});
  std::string all;
  for (const TaskResult& result : results) all += result.bytes;
  write_bytes(folder / "result", all);
}

pid_t start_helper(const fs::path& folder) {
  const pid_t pid = fork();
  if (pid == 0) {
    setenv("JACULUS_TEST_FOLDER", folder.c_str(), 1);
    const int null = ::open("/dev/null", 1);
    dup2(null, 1);
    execl("/proc/self/exe", "test", "--gtest_also_run_disabled_tests",
          "--gtest_filter=TasksHelper.DISABLED_JournalledRun", nullptr);
    _exit(127);
  }
  return pid;
}

std::set<int> executed_tasks(const fs::path& folder) {
  std::ifstream stream(folder / "executed");
  return {std::istream_iterator<int>(stream), std::istream_iterator<int>()};
}

TEST(Tasks, KilledAtRandomMomentsNothingIsLostOrRecomputed) {
  const TempFolder folder;
  const fs::path place = folder / "";
  std::mt19937 random(3);
  std::uniform_int_distribution<int> milliseconds(0, 20);
  int kills = 0;
  std::size_t finished_before = 0;
  for (int round = 0; round < 20; ++round) {
    const std::map<int, std::string> finished = read_journal(folder / "journal").finished;
    EXPECT_GE(finished.size(), finished_before);
    finished_before = finished.size();
    fs::remove(folder / "executed");
    const pid_t pid = start_helper(place);
    ASSERT_GT(pid, 0);
    // Time to start differs from machine to machine; what counts is that the kill falls among the
    // tasks.
    for (int wait = 0;
         wait < 400 && executed_tasks(place).empty() && finished.size() < kKilledTasks; ++wait) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds(random)));
    kill(pid, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(pid, &status, 0), pid);
    if (WIFSIGNALED(status)) ++kills;
    for (const int i : executed_tasks(place))
      EXPECT_FALSE(finished.contains(i)) << "task " << i << " ran again";
  }
  EXPECT_GE(kills, 15);            // a fast machine may be done before the last of them
  EXPECT_GT(finished_before, 0u);  // how many survive depends on the machine's load; some must
  int status = -1;
  ASSERT_GT(waitpid(start_helper(place), &status, 0), 0);
  ASSERT_EQ(status, 0);
  std::string expected;
  for (int i = 0; i < kKilledTasks; ++i) expected += answer(i);
  EXPECT_EQ(read_bytes(folder / "result"), expected);
}

TEST(Tasks, SeedsDiffer) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t base = 0; base < 30; ++base) {
    for (std::uint64_t i = 0; i < 30; ++i) seeds.insert(task_seed(base, i));
  }
  EXPECT_EQ(seeds.size(), 900u);
}

}  // namespace
}  // namespace jaculus
