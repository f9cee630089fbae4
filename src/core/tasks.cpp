#include "jaculus/core/tasks.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <chrono>
#include <exception>
#include <mutex>
#include <optional>

#include "core/isolate.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/journal.h"

namespace jaculus {
namespace {

/// What the workers of one run share.
class Run {
 public:
  Run(int count, const std::function<std::string(int)>& task, const TaskOptions& options)
      : task_(task), options_(options), results_(count) {
    if (!options.journal.empty()) resume(count);
    total_ = std::min(count, options.until.value_or(count));
    for (int i = 0; i < total_; ++i) {
      if (!results_[i].resumed) waiting_.push_back(i);
    }
    done_ = total_ - count_of(waiting_);
  }

  /// A worker's life: the next task that nobody has taken, until none is left.
  void work() {
    for (std::size_t k = next_++; k < waiting_.size(); k = next_++) {
      if (interrupt_requested()) return;
      finish(waiting_[k], run_one(waiting_[k]));
    }
  }

  [[nodiscard]] int waiting() const { return count_of(waiting_); }
  [[nodiscard]] std::vector<TaskResult> take_results() { return std::move(results_); }

 private:
  void resume(int count) {
    journal_.emplace(options_.journal, fmt::format("{} tasks; {}", count, options_.fingerprint));
    const JournalContent& content = journal_->content();
    for (const auto& [index, bytes] : content.finished) {
      if (index < 0 || index >= count) continue;  // can't be under a matching key
      results_[index] = {TaskState::done, bytes, "", true};
    }
    if (content.torn_bytes > 0 && options_.notice) {
      options_.notice(fmt::format(
          "{}: the last {} bytes were cut short by an interruption; that task runs again",
          options_.journal.string(), content.torn_bytes));
    }
  }

  TaskResult run_one(int index) {
    if (options_.isolate) {
      return detail::run_isolated([&] { return task_(index); }, options_.time_limit_s,
                                  [&] {
                                    if (journal_) journal_->close_in_child();
                                  });
    }
    try {
      return {TaskState::done, task_(index), "", false};
    } catch (const std::exception& error) {
      return {TaskState::failed, "", error.what(), false};
    } catch (...) {
      return {TaskState::failed, "", "an exception that is not a std::exception", false};
    }
  }

  void finish(int index, TaskResult result) {
    const std::lock_guard lock(mutex_);
    const bool cancelled = result.state == TaskState::cancelled;
    if (result.state == TaskState::done && journal_) journal_->append(index, result.bytes);
    results_[index] = std::move(result);
    if (cancelled) return;
    ++done_;
    ++done_now_;
    if (!options_.progress) return;
    TaskProgress progress{done_, total_, 0.0, 0.0};
    progress.elapsed_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    progress.remaining_s = progress.elapsed_s / done_now_ * (progress.total - progress.done);
    options_.progress(progress);
  }

  const std::function<std::string(int)>& task_;
  const TaskOptions& options_;
  std::vector<TaskResult> results_;
  std::vector<int> waiting_;  ///< indices to run, in order
  std::optional<Journal> journal_;
  std::atomic<std::size_t> next_{0};
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::mutex mutex_;  ///< guards all below, results_ and journal_ while workers run
  int total_ = 0;
  int done_ = 0;
  int done_now_ = 0;
};

}  // namespace

std::vector<TaskResult> run_tasks(int count, const std::function<std::string(int)>& task,
                                  const TaskOptions& options) {
  assert(count >= 0 && options.workers >= 0);
  Run run(count, task, options);
  const int cores = oneapi::tbb::info::default_concurrency();
  const int workers = std::min(options.workers > 0 ? options.workers : cores, run.waiting());

  // A forked child has none of its parent's threads, so what it starts itself runs one after the
  // other.
  if (workers <= 1 || detail::is_isolated_child()) {
    run.work();
    return run.take_results();
  }

  // Isolated workers mostly wait, so more of them than cores is a choice that TBB must be told of.
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                          std::max(workers, cores));
  oneapi::tbb::task_arena arena(workers);
  arena.execute([&] {
    oneapi::tbb::task_group group;
    for (int w = 1; w < workers; ++w) group.run([&] { run.work(); });
    group.run_and_wait([&] { run.work(); });
  });

  return run.take_results();
}

std::uint64_t task_seed(std::uint64_t base, std::uint64_t index) {
  std::uint64_t z = base + (index + 1) * 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace jaculus
