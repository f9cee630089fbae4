// Lists of tasks: their order, processes, failures, time limits and interrupts.

#include "jaculus/core/tasks.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/task_answer.h"
#include "jaculus/core/interrupt.h"

namespace jaculus {
namespace {

using test::answer;

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

TEST(Tasks, SeedsDiffer) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t base = 0; base < 30; ++base) {
    for (std::uint64_t i = 0; i < 30; ++i) seeds.insert(task_seed(base, i));
  }
  EXPECT_EQ(seeds.size(), 900u);
}

}  // namespace
}  // namespace jaculus
