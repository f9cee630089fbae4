#pragma once
// Tasks on this machine's cores, without a journal.

#include <functional>
#include <vector>

#include "jaculus/core/tasks.h"

namespace jaculus::detail {

struct LocalRun {
  int workers = 0;  ///< 0: one a core
  bool isolate = true;
  double time_limit_s = kInfinity;
  std::function<void()> in_child = {};  ///< first of all, in an isolated task's process
  /// One call at a time, as the next; where it says false, no further task begins.
  std::function<bool(int index)> begin = {};
  std::function<void(int index, TaskResult)> end = {};  ///< not for those that never began
};

/// Runs the tasks of these indices, in this order as workers come free, until interrupted.
void run_local(const std::vector<int>& indices, const std::function<std::string(int)>& task,
               const LocalRun& run);

}  // namespace jaculus::detail
