#pragma once
// The submitting side of an executor: arrays of jobs, and what comes of them.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/core/executor.h"
#include "jaculus/core/tasks.h"

namespace jaculus::detail {

/// Has the tasks without a result, of the first `total`, run on the cluster and hands over every
/// result, until all are there or interrupted. What an earlier submission of the same list (its
/// key) has finished or is still running is taken over. A task during which jobs were lost
/// kMostLosses times has failed, and so have all once as many jobs in a row were lost for each of
/// the elements, as on a full disk. Preemption is no loss.
void submit(const std::vector<TaskResult>& known, int total,
            const std::function<std::string(int)>& task, const TaskOptions& options,
            const std::string& key, const std::function<void(int, TaskResult)>& take);

/// How often a task may be under way when its job is lost: twice may be bad luck with nodes, thrice
/// is the task's doing (memory, time limit).
inline constexpr int kMostLosses = 3;

/// Consecutive parts of `indices` of about `chunk_s` of work each; smaller where that would leave
/// nodes idle, larger where an array would have too many elements.
std::vector<std::vector<int>> chunks_of(const std::vector<int>& indices, double cost_s,
                                        double chunk_s);

}  // namespace jaculus::detail
