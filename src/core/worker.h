#pragma once
// The working side of an executor: one element of an array.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/core/tasks.h"

namespace jaculus::detail {

/// What the batch script sets: "ROUND STAGE".
inline constexpr const char* kWorkerVariable = "JACULUS_WORKER";

/// Runs this element's chunk and throws WorkerDone, where this list is the one it is for. For one
/// that comes before, its results. InputError where the list is not the one that was submitted.
std::vector<TaskResult> run_as_worker(int count, const std::function<std::string(int)>& task,
                                      const TaskOptions& options, const std::string& key);

}  // namespace jaculus::detail
