#include "jaculus/core/tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <optional>

#include "core/isolate.h"
#include "core/run_local.h"
#include "core/submission.h"
#include "core/worker.h"
#include "jaculus/core/executor.h"
#include "jaculus/core/journal.h"

namespace jaculus {
namespace {

std::string journal_key(int count, const TaskOptions& options) {
  return fmt::format("{} tasks; {}", count, options.fingerprint);
}

/// What is known of a list of tasks: results, the journal that keeps them, progress.
class Book {
 public:
  Book(int count, const TaskOptions& options) : options_(options), results_(count) {
    total_ = std::min(count, options.until.value_or(count));
    if (!options.journal.empty()) resume(count);
    done_ = total_ - count_of(waiting());
  }

  void take(int index, TaskResult result) {
    const bool known = results_[index].state != TaskState::cancelled;
    if (known || result.state == TaskState::cancelled) return;
    if (result.state == TaskState::done && journal_) journal_->append(index, result.bytes);
    results_[index] = std::move(result);
    ++done_;
    ++done_now_;
    if (!options_.progress) return;
    TaskProgress progress{done_, total_, 0.0, 0.0};
    progress.elapsed_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    progress.remaining_s = progress.elapsed_s / done_now_ * (progress.total - progress.done);
    options_.progress(progress);
  }

  /// Indices to run that have no result yet, in order.
  [[nodiscard]] std::vector<int> waiting() const {
    std::vector<int> indices;
    for (int i = 0; i < total_; ++i)
      if (results_[i].state == TaskState::cancelled) indices.push_back(i);
    return indices;
  }

  void close_in_child() {
    if (journal_) journal_->close_in_child();
  }

  [[nodiscard]] const std::vector<TaskResult>& results() const { return results_; }
  [[nodiscard]] std::vector<TaskResult> take_results() { return std::move(results_); }

 private:
  void resume(int count) {
    journal_.emplace(options_.journal, journal_key(count, options_));
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

  const TaskOptions& options_;
  std::vector<TaskResult> results_;
  std::optional<Journal> journal_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  int total_ = 0;
  int done_ = 0;
  int done_now_ = 0;
};

}  // namespace

std::vector<TaskResult> run_tasks(int count, const std::function<std::string(int)>& task,
                                  const TaskOptions& options) {
  assert(count >= 0 && options.workers >= 0);
  const bool elsewhere = options.executor && !detail::is_isolated_child();
  const std::string key = journal_key(count, options);
  if (elsewhere && !worker_stage().empty()) return detail::run_as_worker(count, task, options, key);

  Book book(count, options);
  const auto take = [&](int index, TaskResult result) { book.take(index, std::move(result)); };
  if (elsewhere) {
    const int total = std::min(count, options.until.value_or(count));
    detail::submit(book.results(), total, task, options, key, take);
    return book.take_results();
  }

  detail::LocalRun run;
  run.workers = options.workers;
  run.isolate = options.isolate;
  run.time_limit_s = options.time_limit_s;
  run.in_child = [&] { book.close_in_child(); };
  run.end = take;
  detail::run_local(book.waiting(), task, run);
  return book.take_results();
}

std::uint64_t task_seed(std::uint64_t base, std::uint64_t index) {
  std::uint64_t z = base + (index + 1) * 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace jaculus
