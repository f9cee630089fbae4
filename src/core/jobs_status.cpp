// What the folders of an executor tell: for people, without touching them.

#include <fmt/format.h>

#include <chrono>
#include <set>

#include "core/slurm.h"
#include "core/stage_folder.h"
#include "jaculus/core/error.h"
#include "jaculus/core/executor.h"
#include "jaculus/core/types.h"

namespace jaculus {
namespace {

namespace fs = std::filesystem;

/// Elements by state, and how many tasks those that run have begun and not finished.
void add_elements(const detail::StageFolder& folder, const std::set<int>& finished,
                  JobsStatus& status) {
  for (int number = 1; number <= folder.rounds(); ++number) {
    const detail::Round round = folder.round(number);
    const auto states = round.job.empty() ? std::nullopt : detail::element_states(round.job);
    for (int c = 0; states && c < count_of(round.chunks); ++c) {
      const auto found = states->find(c);
      if (found == states->end()) continue;
      const auto& [state, reason, node] = found->second;
      const bool why = !reason.empty() && reason != "None";
      ++status.elements[why ? fmt::format("{} ({})", state, reason) : state];
      if (state != "RUNNING") continue;
      for (const int index : folder.begun({number, c}))
        if (!finished.contains(index)) ++status.running;
    }
  }
}

/// From the first submission to the last result [s]; 0 where there is neither.
double span_s(const detail::StageFolder& folder, bool finished) {
  std::error_code code;
  const auto begin = fs::last_write_time(folder.path() / "round_1.json", code);
  if (code) return 0.0;
  auto end = finished ? begin : fs::file_time_type::clock::now();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.path() / "done"))
    end = std::max(end, entry.last_write_time());
  return std::chrono::duration<double>(end - begin).count();
}

JobsStatus status_of(const fs::path& path) {
  detail::StageFolder folder(path);
  folder.read();
  JobsStatus status;
  status.stage = folder.stage();
  status.tasks = folder.asked();

  std::set<int> finished;
  for (const auto& [index, bytes] : folder.fresh("done"))
    if (index < status.tasks) finished.insert(index);
  status.done = count_of(finished);
  for (const auto& [index, why] : folder.fresh("failed"))
    if (index < status.tasks && finished.insert(index).second) status.failed[why].push_back(index);
  add_elements(folder, finished, status);

  const double left = status.tasks - count_of(finished);
  status.elapsed_s = span_s(folder, left == 0.0);
  status.remaining_s = finished.empty() ? kNaN : status.elapsed_s / count_of(finished) * left;
  return status;
}

}  // namespace

std::vector<JobsStatus> jobs_status(const fs::path& folder) {
  std::vector<JobsStatus> all;
  for (const fs::path& stage : detail::stage_folders(folder)) all.push_back(status_of(stage));
  if (all.empty()) {
    throw InputError(fmt::format(
        "{}: no jobs are there; allowed: the --out of a run with --executor slurm that is not over",
        folder.string()));
  }
  return all;
}

void remove_jobs(const Executor& executor) {
  std::error_code code;
  fs::remove_all(executor.folder, code);  // what can't be removed is in nobody's way
}

}  // namespace jaculus
