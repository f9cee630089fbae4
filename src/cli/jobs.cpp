// jaculus jobs: what of a run on a cluster is done, running and failed.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/reporting.h"
#include "jaculus/core/executor.h"
#include "jaculus/core/json.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct JobsOptions {
  Common common;
  std::string folder;
};

Json to_json(const JobsStatus& status) {
  Json failed = Json::array();
  for (const auto& [reason, tasks] : status.failed)
    failed.push_back({{"reason", reason}, {"tasks", tasks}});
  int count = 0;
  for (const auto& [reason, tasks] : status.failed) count += count_of(tasks);
  return {{"stage", status.stage},
          {"tasks", status.tasks},
          {"done", status.done},
          {"running", status.running},
          {"failed", count},
          {"why", failed},
          {"elements", status.elements},
          {"elapsed_s", status.elapsed_s},
          {"remaining_s", json_number(status.remaining_s)}};
}

std::string text_of(const JobsStatus& status) {
  const Json json = to_json(status);
  std::string text =
      fmt::format("{}: {} tasks, {} done, {} running, {} failed\n", status.stage, status.tasks,
                  status.done, status.running, json["failed"].get<int>());
  for (const auto& [state, count] : status.elements)
    text += fmt::format("  {} elements {}\n", count, state);
  constexpr std::size_t kShown = 10;  // of the tasks that share a reason
  for (const auto& [reason, tasks] : status.failed) {
    const std::size_t shown = std::min(tasks.size(), kShown);
    std::vector<int> first;
    for (std::size_t i = 0; i < shown; ++i) first.push_back(tasks[i] + 1);
    text += fmt::format(
        "  failed: {}{}: {}\n", fmt::join(first, ", "),
        shown < tasks.size() ? fmt::format(" and {} more", tasks.size() - shown) : "", reason);
  }
  const bool open = status.done + json["failed"].get<int>() < status.tasks;
  if (open)
    text += fmt::format("  {}, about {} to go\n", duration(status.elapsed_s),
                        duration(status.remaining_s));
  return text;
}

/// The folder itself, or the one that a command with this --out or --key makes.
fs::path jobs_in(const fs::path& given) {
  const fs::path beside = given.lexically_normal().string() + ".jobs";
  for (const fs::path& folder : {jobs_folder(given), beside})
    if (fs::is_directory(folder)) return folder;
  return given;
}

int run_jobs(const JobsOptions& options) {
  Json list = Json::array();
  std::string text;
  for (const JobsStatus& status : jobs_status(jobs_in(options.folder))) {
    list.push_back(to_json(status));
    text += text_of(status);
  }
  print(options.common.json ? list.dump(1) + "\n" : text);
  return kDone;
}

}  // namespace

void add_jobs(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<JobsOptions>();
  CLI::App* command = app.add_subcommand(
      "jobs", "What of a run with --executor slurm is done, running, failed and why.");
  command->footer("Example:\n  jaculus jobs fig3");
  command
      ->add_option("folder", options->folder,
                   "the run's --out, or for `testbed seal` its --key; once the run is over, "
                   "nothing is left there to tell")
      ->required();
  command->add_flag("--json", options->common.json, "machine-readable");
  command->callback([options, &chosen] { chosen = [options] { return run_jobs(*options); }; });
}

}  // namespace jaculus::cli
