#include "core/run_local.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>

#include "core/isolate.h"
#include "jaculus/core/interrupt.h"

namespace jaculus::detail {
namespace {

TaskResult run_one(int index, const std::function<std::string(int)>& task, const LocalRun& run) {
  if (run.isolate) {
    return run_isolated([&] { return task(index); }, run.time_limit_s,
                        [&] {
                          if (run.in_child) run.in_child();
                        });
  }
  try {
    return {TaskState::done, task(index), "", false};
  } catch (const std::exception& error) {
    return {TaskState::failed, "", error.what(), false};
  } catch (...) {
    return {TaskState::failed, "", "an exception that is not a std::exception", false};
  }
}

}  // namespace

void run_local(const std::vector<int>& indices, const std::function<std::string(int)>& task,
               const LocalRun& run) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t k = next++; k < indices.size(); k = next++) {
      if (interrupt_requested()) return;
      if (run.begin) {
        const std::lock_guard lock(mutex);
        if (!run.begin(indices[k])) return;
      }
      TaskResult result = run_one(indices[k], task, run);
      const std::lock_guard lock(mutex);
      run.end(indices[k], std::move(result));
    }
  };

  // A forked child has none of its parent's threads, so what it starts itself runs one after the
  // other.
  const int cores = oneapi::tbb::info::default_concurrency();
  const int workers = std::min(run.workers > 0 ? run.workers : cores, count_of(indices));
  if (workers <= 1 || is_isolated_child()) return work();

  // Isolated workers mostly wait, so more of them than cores is a choice that TBB must be told of.
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                          std::max(workers, cores));
  oneapi::tbb::task_arena arena(workers);
  arena.execute([&] {
    oneapi::tbb::task_group group;
    for (int w = 1; w < workers; ++w) group.run(work);
    group.run_and_wait(work);
  });
}

}  // namespace jaculus::detail
