// Journals, and runs that are stopped, killed or run in parts and go on from theirs.

#include "jaculus/core/journal.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/task_answer.h"
#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/tasks.h"
#include "support/temporary_folder.h"

namespace jaculus {
namespace {

namespace fs = std::filesystem;

using test::answer;
using test::bytes_of;
using test::TemporaryFolder;

TEST(Journal, RefusesAnotherListOfTasks) {
  const TemporaryFolder folder;
  TaskOptions options{.journal = folder / "journal", .fingerprint = "a"};
  run_tasks(3, answer, options);
  EXPECT_THROW(run_tasks(4, answer, options), InputError);
  options.fingerprint = "b";
  EXPECT_THROW(run_tasks(3, answer, options), InputError);
  folder.write("other", "time [s], x [m]\n0, 0\n");
  options.journal = folder / "other";
  EXPECT_THROW(run_tasks(3, answer, options), InputError);
  EXPECT_EQ(bytes_of(folder / "other"), "time [s], x [m]\n0, 0\n");
}

TEST(Journal, IsLocked) {
  const TemporaryFolder folder;
  const Journal first(folder / "journal", "key");
  EXPECT_THROW(Journal(folder / "journal", "key"), InputError);
}

TEST(Journal, EveryTornTailIsCutOff) {
  const TemporaryFolder folder;
  {
    Journal journal(folder / "whole", "key");
    for (int i = 0; i < 3; ++i) journal.append(i, answer(i));
  }
  const std::string whole = bytes_of(folder / "whole");
  const std::size_t record = 24;  // index, length and check around a payload
  const std::size_t header =
      whole.size() - 3 * record - answer(0).size() - answer(1).size() - answer(2).size();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    folder.write("torn", whole.substr(0, size));
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
  const TemporaryFolder folder;
  {
    Journal journal(folder / "journal", "key");
    for (int i = 0; i < 2; ++i) journal.append(i, answer(i));
  }
  const std::string whole = bytes_of(folder / "journal");
  for (std::size_t at = whole.size() - answer(1).size() - 24; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    folder.write("damaged", damaged);
    const JournalContent content = read_journal(folder / "damaged");
    EXPECT_EQ(content.finished.size(), 1u) << at;
    EXPECT_GT(content.torn_bytes, 0u);
  }
}

TEST(Tasks, InterruptKeepsWhatIsFinished) {
  const TemporaryFolder folder;
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

TEST(Tasks, FailedTasksRunAgainOnResume) {
  const TemporaryFolder folder;
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
  const TemporaryFolder folder;
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
  std::ofstream(folder / "result", std::ios::binary) << all;
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
  const TemporaryFolder folder;
  const fs::path place = folder.path();
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
  EXPECT_EQ(bytes_of(folder / "result"), expected);
}

}  // namespace
}  // namespace jaculus
