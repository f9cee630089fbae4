#pragma once
// Independent jobs on all cores, as a value: results come in task order whatever the number of
// workers and whatever was resumed. Workers are oneTBB's. An isolated task runs in a forked child
// and hands its bytes back through a pipe: solvers that keep global state (MUMPS) can then run side
// by side, and a crash is one task's failure, not the program's.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus {

struct Executor;

enum class TaskState {
  done,
  failed,    ///< an exception, a crash, or out of its time; `error` says which
  cancelled  ///< interrupted before or while it ran
};

struct TaskResult {
  TaskState state = TaskState::cancelled;
  std::string bytes;     ///< what the task returned, where done
  std::string error;     ///< for users, where failed
  bool resumed = false;  ///< taken from the journal, not computed
};

struct TaskProgress {
  int done = 0;  ///< finished, failed or resumed
  int total = 0;
  double elapsed_s = 0.0;  ///< wall time of this run [s]
  /// estimate from the mean of this run; NaN before its first task ends [s]
  double remaining_s = kNaN;
};

struct TaskOptions {
  int workers = 0;                  ///< 0: one a core
  bool isolate = true;              ///< a process of its own for each task
  double time_limit_s = kInfinity;  ///< of one isolated task, wall time [s]

  /// Every task that is done goes here at once and durably, and is taken from here instead of being
  /// run again. Failed and cancelled ones are tried again. Empty: none.
  std::filesystem::path journal = {};
  /// Everything the results depend on (inputs, version). A journal of another fingerprint or count
  /// is refused.
  std::string fingerprint = {};

  /// Only tasks before this index run; the rest is left cancelled. Not part of the journal's key,
  /// so that a later run can go on to more.
  std::optional<int> until = {};

  /// Runs the tasks on a cluster (executor.h); null: here, and so do the tasks of an isolated task.
  std::shared_ptr<const Executor> executor = {};
  /// Names this list among those of its command, as a folder can be named; with an executor only.
  std::string stage = {};

  /// Called after every task, one call at a time, from any worker.
  std::function<void(const TaskProgress&)> progress = {};
  /// One-line messages on what a user should know (a torn journal).
  std::function<void(const std::string&)> notice = {};
};

/// Runs task(0) ... task(count - 1). An isolated task's side effects stay in its child, which must
/// not rely on threads of the parent; tasks that are not isolated must be safe to run at once. Once
/// interrupt_requested() no task is started, isolated ones are ended, and what is finished is
/// returned. InputError for a journal that can't be used.
std::vector<TaskResult> run_tasks(int count, const std::function<std::string(int)>& task,
                                  const TaskOptions& options = {});

/// A seed for task `index` of a run with seed `base`: neighbours share nothing (splitmix64).
std::uint64_t task_seed(std::uint64_t base, std::uint64_t index);

}  // namespace jaculus
