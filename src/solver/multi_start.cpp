#include "jaculus/solver/multi_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace jaculus::solver {
namespace {

const NlpResult* converged_result(const StartOutcome& start) {
  return start.task == TaskState::done && start.result.converged() ? &start.result : nullptr;
}

/// Distance above which two objectives differ, relative to the larger one's size.
bool within(double value, double best, double relative) {
  return value - best <= relative * std::max(std::abs(value), std::abs(best));
}

void choose(MultiStart& all, const MultiStartOptions& options) {
  const std::vector<int> found = optima(all, options.tie);
  if (!found.empty()) all.best = found.front();

  double lowest = kInfinity, least_violation = kInfinity;
  for (const StartOutcome& start : all.starts) {
    if (const NlpResult* result = converged_result(start))
      lowest = std::min(lowest, result->objective);
  }

  int near = 0;
  for (int i = 0; i < count_of(all.starts); ++i) {
    const StartOutcome& start = all.starts[i];
    if (start.task == TaskState::done && start.result.max_scaled_violation < least_violation) {
      least_violation = start.result.max_scaled_violation;
      all.least_bad = i;
    }
    const NlpResult* result = converged_result(start);
    if (result == nullptr) continue;
    ++all.converged;
    if (within(result->objective, lowest, options.near)) ++near;
  }

  const double count = std::max<double>(1.0, static_cast<double>(all.starts.size()));
  all.converged_share = all.converged / count;
  all.near_share = near / count;
}

}  // namespace

std::vector<int> optima(const MultiStart& all, double tie) {
  std::vector<int> order;
  for (int i = 0; i < count_of(all.starts); ++i)
    if (converged_result(all.starts[i]) != nullptr) order.push_back(i);
  const auto objective = [&](int start) { return all.starts[start].result.objective; };
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return objective(a) < objective(b); });

  std::vector<int> found;
  for (std::size_t first = 0, next = 0; first < order.size(); first = next) {
    while (next < order.size() && within(objective(order[next]), objective(order[first]), tie))
      ++next;
    found.push_back(*std::min_element(order.begin() + static_cast<std::ptrdiff_t>(first),
                                      order.begin() + static_cast<std::ptrdiff_t>(next)));
  }
  return found;
}

const NlpResult& MultiStart::best_result() const {
  if (best < 0) throw std::logic_error("no start converged: there is no best one");
  return starts[best].result;
}

MultiStart multi_start(int count,
                       const std::function<NlpResult(int start, std::uint64_t seed)>& solve,
                       const MultiStartOptions& options) {
  assert(count >= 0);
  TaskOptions tasks = options.tasks;
  tasks.fingerprint += fmt::format("; seed {}", options.seed);
  const auto job = [&](int start) {
    return serialise(solve(start, task_seed(options.seed, start)));
  };
  std::vector<TaskResult> results = run_tasks(count, job, tasks);
  MultiStart all;
  for (TaskResult& result : results) {
    StartOutcome outcome{result.state, std::move(result.error), {}};
    if (result.state == TaskState::done) outcome.result = deserialise_result(result.bytes);
    all.starts.push_back(std::move(outcome));
  }
  choose(all, options);
  return all;
}

}  // namespace jaculus::solver
