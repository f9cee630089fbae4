// Arrays of jobs on a Slurm that tests/support/fake_slurm stands for; scripts/check_slurm has the
// real one.
#include "jaculus/core/executor.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "core/stage_folder.h"
#include "core/submission.h"
#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/journal.h"
#include "jaculus/core/tasks.h"

namespace jaculus {
namespace {

namespace fs = std::filesystem;

constexpr int kTasks = 60;

std::string seed_text(int index) { return std::to_string(task_seed(3, index)); }

/// Folders for jobs and for the state of the fake Slurm, which is first on the PATH meanwhile.
class OnFakeSlurm : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "jaculus_executor_XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    fs::create_directory(folder_ / "slurm");
    path_ = std::getenv("PATH");
    const fs::path fake = source_folder() / "tests/support/fake_slurm";
    ASSERT_TRUE(fs::exists(fake / "sbatch")) << fake;
    setenv("PATH", (fake.string() + ":" + path_).c_str(), 1);
    setenv("FAKE_SLURM", (folder_ / "slurm").c_str(), 1);
    setenv("JACULUS_TEST_FOLDER", folder_.c_str(), 1);
  }
  void TearDown() override {
    setenv("PATH", path_.c_str(), 1);
    for (const char* fault :
         {"FAKE_SLURM_KILL", "FAKE_SLURM_REQUEUE", "FAKE_SLURM_REFUSE", "FAKE_SLURM_STATE",
          "FAKE_SLURM_OTHER", "FAKE_SLURM_BUSY", "JACULUS_TEST_FAULT"})
      unsetenv(fault);
    fs::remove_all(folder_);
  }

  std::vector<TaskResult> run(const std::string& fingerprint = "ours");

  /// How often every task was begun on the fake cluster.
  [[nodiscard]] std::map<int, int> begun() const {
    std::map<int, int> times;
    for (const auto& entry : fs::directory_iterator(folder_ / "jobs/list/begun")) {
      std::ifstream stream(entry.path());
      for (int index = 0; stream >> index;) ++times[index];
    }
    return times;
  }

  fs::path folder_;
  std::string path_;
  std::string notices_;
  std::optional<int> limit_;  ///< tasks before it are asked for
};

/// How often this was called, by whatever process.
std::uintmax_t times_called(const fs::path& folder) {
  std::ofstream(folder / "calls", std::ios::app) << '.';
  return fs::file_size(folder / "calls");
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

/// Whether the fake cluster is about to kill this task's worker: it does so once the first element
/// of the first job has begun two tasks.
bool about_to_be_killed(const fs::path& folder) {
  const std::string own =
      environment("SLURM_ARRAY_JOB_ID") + "." + environment("SLURM_ARRAY_TASK_ID");
  if (environment("SLURM_RESTART_COUNT") != "0" ||
      (own != environment("FAKE_SLURM_KILL") && own != environment("FAKE_SLURM_REQUEUE")))
    return false;
  std::ifstream begun(folder / "jobs/list/begun" / (own + ".0"));
  int tasks = 0;
  for (std::string line; std::getline(begun, line);) ++tasks;
  return tasks >= 2;
}

/// The list of tasks that the test submits, and the worker runs.
std::vector<TaskResult> run_list(const fs::path& folder, const std::string& fingerprint,
                                 std::string* notices, std::optional<int> limit = {}) {
  const std::string wrong = environment("JACULUS_TEST_FAULT");
  Executor executor{folder / "jobs",
                    {"/proc/self/exe", "--gtest_also_run_disabled_tests",
                     "--gtest_filter=ExecutorHelper.DISABLED_Worker"}};
  executor.command[0] = fs::read_symlink("/proc/self/exe");
  // of jobs that all are lost some must leave tasks that they never began, however slow a machine
  executor.chunk_s = wrong == "worker_ends" ? 3.0 : 0.4;
  TaskOptions options;
  options.journal = folder / "list.journal";
  options.fingerprint = fingerprint;
  options.executor = std::make_shared<const Executor>(executor);
  options.stage = "list";
  options.until = limit;
  if (notices != nullptr)
    options.notice = [notices](const std::string& text) { *notices += text + "\n"; };

  const auto task = [&](int i) {
    usleep(30'000);
    // However slow the machine, the second task is in flight when its worker is killed.
    const pid_t worker = getppid();
    for (int k = 0; k < 1000 && getppid() == worker && about_to_be_killed(folder); ++k)
      usleep(30'000);
    if (wrong == "throws" && i % 20 == 7) throw std::runtime_error("no such thing");
    if (wrong == "kills" && i == 9) kill(getppid(), SIGKILL);  // its worker: memory ran out, say
    if (wrong == "kills_four_times" && i == 9 && times_called(folder) <= 4)
      kill(getppid(), SIGKILL);
    // as the disk does that is full: the first few tasks run where the list is given
    if (wrong == "worker_ends" && !worker_stage().empty()) kill(getppid(), SIGKILL);
    return seed_text(i);
  };
  return run_tasks(kTasks, task, options);
}

std::vector<TaskResult> OnFakeSlurm::run(const std::string& fingerprint) {
  return run_list(folder_, fingerprint, &notices_, limit_);
}

TEST(ExecutorHelper, DISABLED_Worker) {
  const char* folder = std::getenv("JACULUS_TEST_FOLDER");
  ASSERT_NE(folder, nullptr);
  try {
    run_list(folder, "ours", nullptr);
  } catch (const WorkerDone& done) {
    _exit(done.complete ? 0 : 1);
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    _exit(2);
  }
}

void expect_all(const std::vector<TaskResult>& results) {
  ASSERT_EQ(results.size(), kTasks);
  for (int i = 0; i < kTasks; ++i) {
    ASSERT_EQ(results[i].state, TaskState::done) << i << " " << results[i].error;
    ASSERT_EQ(results[i].bytes, seed_text(i));
  }
}

TEST_F(OnFakeSlurm, ResultsAreThoseOfALocalRun) {
  expect_all(run());
  for (const auto& [index, times] : begun()) EXPECT_EQ(times, 1) << index;
  EXPECT_EQ(read_journal(folder_ / "list.journal").finished.size(), kTasks);
}

TEST_F(OnFakeSlurm, WhatALostNodeTookRunsAgainAndNothingElseDoes) {
  setenv("FAKE_SLURM_KILL", "1.1", 1);
  expect_all(run());
  int again = 0;
  for (const auto& [index, times] : begun()) again += times - 1;
  EXPECT_EQ(again, 1);  // what was in flight
  EXPECT_NE(notices_.find("was lost (NODE_FAIL on here"), std::string::npos) << notices_;
}

TEST_F(OnFakeSlurm, ALaterArrayThatSlurmDoesNotTakeAtOnceIsOfferedAgain) {
  setenv("FAKE_SLURM_KILL", "1.1", 1);
  setenv("FAKE_SLURM_BUSY", "2", 1);
  expect_all(run());
  EXPECT_NE(notices_.find("Slurm takes no jobs, trying again: "), std::string::npos) << notices_;
  EXPECT_TRUE(fs::exists(folder_ / "jobs/list/round_2.id"));
  EXPECT_FALSE(fs::exists(folder_ / "jobs/list/round_3.json"));
}

TEST_F(OnFakeSlurm, ARequeuedElementGoesOn) {
  setenv("FAKE_SLURM_REQUEUE", "1.1", 1);
  expect_all(run());
  int again = 0;
  for (const auto& [index, times] : begun()) again += times - 1;
  EXPECT_EQ(again, 1);
  EXPECT_TRUE(fs::exists(folder_ / "jobs/list/done/1.1.1"));
}

TEST_F(OnFakeSlurm, FailedTasksKeepTheirReason) {
  setenv("JACULUS_TEST_FAULT", "throws", 1);
  const auto results = run();
  for (int i = 0; i < kTasks; ++i) {
    EXPECT_EQ(results[i].state, i % 20 == 7 ? TaskState::failed : TaskState::done) << i;
    EXPECT_EQ(results[i].error, i % 20 == 7 ? "no such thing" : "") << i;
  }
  const JobsStatus status = jobs_status(folder_ / "jobs").at(0);
  EXPECT_EQ(status.done, kTasks - 3);
  EXPECT_EQ(status.failed.at("no such thing"), (std::vector<int>{7, 27, 47}));

  unsetenv("JACULUS_TEST_FAULT");  // and are tried again
  expect_all(run());
}

TEST_F(OnFakeSlurm, ATaskThatKillsItsWorkerFailsAndTheOthersDoNot) {
  setenv("JACULUS_TEST_FAULT", "kills", 1);
  const auto results = run();
  for (int i = 0; i < kTasks; ++i)
    EXPECT_EQ(results[i].state, i == 9 ? TaskState::failed : TaskState::done) << i;
  EXPECT_NE(results[9].error.find("its job was lost 3 times"), std::string::npos)
      << results[9].error;
}

TEST_F(OnFakeSlurm, PreemptionIsNotHeldAgainstATask) {
  setenv("JACULUS_TEST_FAULT", "kills_four_times", 1);
  setenv("FAKE_SLURM_STATE", "PREEMPTED", 1);
  expect_all(run());
  EXPECT_NE(notices_.find("was lost (PREEMPTED"), std::string::npos) << notices_;
}

TEST_F(OnFakeSlurm, JobsThatAllAreLostEndTheList) {
  setenv("JACULUS_TEST_FAULT", "worker_ends", 1);
  const auto results = run();
  int lost = 0;
  for (const TaskResult& result : results)
    lost += result.error.find("jobs in a row were lost without a result") != std::string::npos;
  EXPECT_GT(lost, kTasks / 2) << results.back().error;
  for (const TaskResult& result : results) EXPECT_NE(result.state, TaskState::cancelled);
}

TEST_F(OnFakeSlurm, AnArrayOfAnotherSubmissionRunsNothing) {
  setenv("FAKE_SLURM_OTHER", "77", 1);
  const auto results = run();
  EXPECT_NE(results.back().error.find("Slurm job 77 is not what was submitted as round"),
            std::string::npos)
      << results.back().error;
  EXPECT_TRUE(begun().empty());
}

TEST_F(OnFakeSlurm, StatusIsOfWhatWasAskedFor) {
  limit_ = 20;
  const auto results = run();
  EXPECT_EQ(results[19].state, TaskState::done);
  EXPECT_EQ(results[20].state, TaskState::cancelled);
  const JobsStatus status = jobs_status(folder_ / "jobs").at(0);
  EXPECT_EQ(status.tasks, 20);
  EXPECT_EQ(status.done, 20);
  EXPECT_EQ(status.remaining_s, 0.0);
}

TEST_F(OnFakeSlurm, AnotherListIsRefused) {
  expect_all(run());
  fs::remove(folder_ / "list.journal");
  EXPECT_THROW(run("another"), InputError);
}

TEST_F(OnFakeSlurm, AWorkerWithOtherInputsSaysSo) {
  std::string error;
  const auto results = run("another");  // workers know "ours" alone
  for (const TaskResult& result : results)
    if (result.state == TaskState::failed) error = result.error;
  EXPECT_NE(error.find("are not what they were on submission"), std::string::npos) << error;
}

TEST_F(OnFakeSlurm, ARefusedSubmissionIsAnErrorWithSlurmsWords) {
  setenv("FAKE_SLURM_REFUSE", "1", 1);
  try {
    run();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("invalid partition"), std::string::npos);
  }
  unsetenv("FAKE_SLURM_REFUSE");  // what ran before is kept
  EXPECT_FALSE(read_journal(folder_ / "list.journal").finished.empty());
  expect_all(run());
}

TEST(Chunks, HoldEveryIndexOnceInOrder) {
  std::vector<int> indices(12345);
  std::iota(indices.begin(), indices.end(), 3);
  for (const double cost : {1e-4, 0.1, 3.0, 1e4}) {
    std::vector<int> together;
    const auto chunks = detail::chunks_of(indices, cost, 300.0);
    EXPECT_LE(chunks.size(), 1000u) << cost;
    for (const auto& chunk : chunks) together.insert(together.end(), chunk.begin(), chunk.end());
    EXPECT_EQ(together, indices) << cost;
  }
}

TEST(Chunks, AreSizedByCost) {
  std::vector<int> indices(6400);
  EXPECT_EQ(detail::chunks_of(indices, 1.0, 300.0).size(), 64u);    // a share for every node
  EXPECT_EQ(detail::chunks_of(indices, 10.0, 300.0).size(), 214u);  // 300 s each
  EXPECT_EQ(detail::chunks_of(indices, 1e-3, 300.0).size(), 1u);    // not worth more than one
}

TEST(StageFolder, RangesComeBack) {
  const std::vector<int> indices{0, 1, 2, 7, 9, 10};
  EXPECT_EQ(detail::ranges_text(indices), "0-2,7,9-10");
  EXPECT_EQ(detail::ranges_of("0-2,7,9-10"), indices);
  EXPECT_TRUE(detail::ranges_of("").empty());
  EXPECT_THROW(detail::ranges_of("1-x"), InputError);
}

TEST(StageFolder, AWorkerIsSupersededOnceItsElementIsRequeuedOrGivenUp) {
  std::string name = (fs::temp_directory_path() / "jaculus_stage_XXXXXX").string();
  ASSERT_NE(mkdtemp(name.data()), nullptr);
  detail::StageFolder folder(fs::path(name) / "list");
  folder.open("list", 3, "key");
  const detail::Element element{1, 7}, other{1, 70};
  EXPECT_FALSE(folder.superseded(element, 0));
  std::ofstream(folder.file("begun", "1.7.0")).flush();
  EXPECT_FALSE(folder.superseded(element, 0));
  std::ofstream(folder.file("begun", "1.7.1")).flush();
  EXPECT_TRUE(folder.superseded(element, 0));
  EXPECT_FALSE(folder.superseded(element, 1));
  folder.give_up(element);
  EXPECT_TRUE(folder.superseded(element, 1));
  EXPECT_FALSE(folder.superseded(other, 0));
  fs::remove_all(name);
}

TEST(SlurmOptions, AreSplitAsByAShell) {
  EXPECT_EQ(split_options("--time=1:00  --comment='a b' -p \"x y\""),
            (std::vector<std::string>{"--time=1:00", "--comment=a b", "-p", "x y"}));
  EXPECT_TRUE(split_options("  ").empty());
  EXPECT_THROW(split_options("--comment='a"), InputError);
}

TEST(JournalTail, TakesEveryRecordOnceAndNoneThatIsTorn) {
  std::string name = (fs::temp_directory_path() / "jaculus_tail_XXXXXX").string();
  ASSERT_NE(mkdtemp(name.data()), nullptr);
  const fs::path file = fs::path(name) / "journal";
  JournalTail tail(file);
  EXPECT_TRUE(tail.take("key").empty());
  Journal journal(file, "key", JournalLock::sole_writer);
  EXPECT_TRUE(tail.take("key").empty());
  journal.append(4, "four");
  EXPECT_EQ(tail.take("key"), (std::map<int, std::string>{{4, "four"}}));
  const auto whole = fs::file_size(file);
  journal.append(5, "five");
  const std::string bytes = [&] {
    std::ifstream stream(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  }();
  for (std::size_t size = whole; size < bytes.size(); ++size) {
    fs::resize_file(file, size);
    EXPECT_TRUE(tail.take("key").empty()) << size;
  }
  std::ofstream(file, std::ios::binary) << bytes;
  EXPECT_EQ(tail.take("key"), (std::map<int, std::string>{{5, "five"}}));
  EXPECT_TRUE(tail.take("key").empty());
  EXPECT_THROW(JournalTail(file).take("other"), InputError);
  fs::remove_all(name);
}

}  // namespace
}  // namespace jaculus
