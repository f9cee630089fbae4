#include "core/worker.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

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
  int restarts = 0;  ///< how often the element was requeued
  int cores = 1;

  [[nodiscard]] std::string worker() const { return element.worker(restarts); }
};

Assignment assignment() {
  Assignment a;
  std::istringstream(variable_or(detail::kWorkerVariable, "")) >> a.element.round;
  a.stage = worker_stage();
  try {
    a.element.chunk = std::stoi(variable_or("SLURM_ARRAY_TASK_ID", "-1"));
    a.cores = std::max(1, std::stoi(variable_or("SLURM_CPUS_PER_TASK", "1")));
    a.restarts = std::stoi(variable_or("SLURM_RESTART_COUNT", "0"));
  } catch (const std::exception&) {
    throw InputError(
        "SLURM_ARRAY_TASK_ID, SLURM_CPUS_PER_TASK or SLURM_RESTART_COUNT: not a number, as Slurm "
        "sets them");
  }
  return a;
}

/// Whether `condition` holds within the time that NFS takes to show what other machines wrote.
bool comes_true(const std::function<bool()>& condition) {
  const auto begin = std::chrono::steady_clock::now();
  while (!condition()) {
    if (interrupt_requested()) return false;
    if (std::chrono::steady_clock::now() - begin > detail::kNfsDelay) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return true;
}

/// Results of a list that was finished before the one that this process is a worker of.
std::vector<TaskResult> results_of(detail::StageFolder& folder) {
  std::vector<TaskResult> results(folder.count());
  int known = 0;
  const auto take = [&](const char* kind, TaskState state) {
    for (auto& [index, bytes] : folder.fresh(kind)) {
      TaskResult& result = results.at(index);
      if (result.state != TaskState::cancelled) continue;
      ++known;
      result.state = state;
      result.resumed = true;
      (state == TaskState::done ? result.bytes : result.error) = std::move(bytes);
    }
  };
  const bool whole = comes_true([&] {
    take("done", TaskState::done);
    take("failed", TaskState::failed);
    folder.read();
    return folder.finished() && known >= *folder.finished();
  });
  if (whole) return results;
  throw InputError(fmt::format("{}: results are missing; allowed: a folder that all machines share",
                               folder.path().string()));
}

/// Nobody waits for an array whose submitter was killed before it noted the id, nor for one of a
/// run that was begun anew since. Its files would have two writers.
void check_array(const detail::StageFolder& folder, int round) {
  const std::string own = variable_or("SLURM_ARRAY_JOB_ID", "");
  std::string submitted;
  const bool known = comes_true([&] { return !(submitted = folder.round(round).job).empty(); });
  if (own.empty() || (known && submitted == own)) return;
  throw InputError(fmt::format("{}: Slurm job {} is not what was submitted as round {}",
                               folder.path().string(), own, round));
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
  const std::string text = variable_or(detail::kWorkerVariable, "");
  return text.substr(text.find(' ') + 1);
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
  check_array(folder, own.element.round);

  const std::vector<int> left = left_of(folder, own.element, key);
  Journal done(folder.file("done", own.worker()), key, JournalLock::sole_writer);
  Journal failed(folder.file("failed", own.worker()), key, JournalLock::sole_writer);
  std::ofstream begun(folder.file("begun", own.worker()), std::ios::app);

  LocalRun run;
  run.workers = own.cores;
  run.isolate = options.isolate;
  run.time_limit_s = options.time_limit_s;
  run.begin = [&](int index) {
    if (folder.superseded(own.element, own.restarts)) return false;
    begun << index << std::endl;
    return true;
  };
  run.end = [&](int index, const TaskResult& result) {
    if (result.state == TaskState::done) done.append(index, result.bytes);
    if (result.state == TaskState::failed) failed.append(index, result.error);
  };
  run_local(left, task, run);
  throw WorkerDone{!interrupt_requested()};
}

}  // namespace jaculus
