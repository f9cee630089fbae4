#include "core/worker.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "core/run_local.h"
#include "core/stage_folder.h"
#include "jaculus/core/error.h"
#include "jaculus/core/executor.h"
#include "jaculus/core/interrupt.h"

namespace jaculus {
namespace {

std::string variable_or(const char* name, const char* otherwise) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0' ? value : otherwise;
}

struct Assignment {
  std::string stage;
  detail::Element element;
  std::string worker;  ///< of the element, as often as it was requeued: "1.7.0"
  int cores = 1;
};

Assignment assignment() {
  Assignment a;
  std::istringstream(variable_or(detail::kWorkerVariable, "")) >> a.stage >> a.element.round;
  try {
    a.element.chunk = std::stoi(variable_or("SLURM_ARRAY_TASK_ID", "-1"));
    a.cores = std::max(1, std::stoi(variable_or("SLURM_CPUS_PER_TASK", "1")));
  } catch (const std::exception&) {
    throw InputError("SLURM_ARRAY_TASK_ID or SLURM_CPUS_PER_TASK: not a number, as Slurm sets it");
  }
  a.worker = a.element.name() + "." + variable_or("SLURM_RESTART_COUNT", "0");
  return a;
}

/// Results of a list whose stage has been finished.
std::vector<TaskResult> results_of(detail::StageFolder& folder) {
  std::vector<TaskResult> results(folder.count());
  for (auto& [index, bytes] : folder.fresh("done"))
    results.at(index) = {TaskState::done, std::move(bytes), "", true};
  for (auto& [index, why] : folder.fresh("failed")) {
    if (results.at(index).state == TaskState::cancelled)
      results[index] = {TaskState::failed, "", std::move(why), true};
  }
  return results;
}

/// Of the chunk, what no earlier worker of this element finished.
std::vector<int> left_of(const detail::StageFolder& folder, const detail::Element& element,
                         const std::string& key) {
  const detail::Round round = folder.round(element.round);
  if (element.chunk < 0 || element.chunk >= count_of(round.chunks))
    throw InputError(fmt::format("{}: no element {}", folder.path().string(), element.name()));

  std::set<int> finished;
  for (const char* kind : {"done", "failed"}) {
    for (const std::string& name : folder.workers(kind, element))
      for (const auto& [index, bytes] : JournalTail(folder.file(kind, name)).take(key))
        finished.insert(index);
  }
  std::vector<int> left;
  for (const int index : round.chunks[element.chunk])
    if (!finished.contains(index)) left.push_back(index);
  return left;
}

}  // namespace

std::string worker_stage() {
  std::string stage;
  std::istringstream(variable_or(detail::kWorkerVariable, "")) >> stage;
  return stage;
}

std::vector<TaskResult> detail::run_as_worker(int count,
                                              const std::function<std::string(int)>& task,
                                              const TaskOptions& options, const std::string& key) {
  StageFolder folder(options.executor->folder / options.stage);
  folder.read();
  if (folder.key() != key || folder.count() != count) {
    throw InputError(fmt::format(
        "{}: files that the tasks depend on are not what they were on submission; allowed: the "
        "same files and the same program on all machines",
        folder.path().string()));
  }
  const Assignment own = assignment();
  if (own.stage != options.stage) return results_of(folder);

  const std::vector<int> left = left_of(folder, own.element, key);
  Journal done(folder.file("done", own.worker), key, JournalLock::sole_writer);
  Journal failed(folder.file("failed", own.worker), key, JournalLock::sole_writer);
  std::ofstream begun(folder.file("begun", own.worker), std::ios::app);

  LocalRun run;
  run.workers = own.cores;
  run.isolate = options.isolate;
  run.time_limit_s = options.time_limit_s;
  run.begin = [&](int index) { begun << index << std::endl; };
  run.end = [&](int index, const TaskResult& result) {
    if (result.state == TaskState::done) done.append(index, result.bytes);
    if (result.state == TaskState::failed) failed.append(index, result.error);
  };
  run_local(left, task, run);
  throw WorkerDone{!interrupt_requested()};
}

}  // namespace jaculus
