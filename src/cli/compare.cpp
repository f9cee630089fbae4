// jaculus compare: several problems, solved and tabulated against each other.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <set>

#include "cli/plan.h"
#include "cli/reporting.h"
#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/journal.h"
#include "jaculus/core/tasks.h"
#include "jaculus/report/compare_report.h"
#include "jaculus/studies/comparison.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/transcription/describe.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct CompareOptions {
  Common common;
  std::vector<std::string> problems;
  bool resume = false;
};

std::vector<Loaded> load_all(const CompareOptions& options) {
  std::vector<Loaded> all;
  std::set<std::string> names;
  for (const std::string& file : options.problems) {
    all.push_back(load(file, options.common));
    const transcription::Problem& problem = all.back().problem;
    if (!names.insert(problem.name).second) {
      throw problem.node.at("name").error(
          fmt::format("'{}' names another of these problems already; allowed: unique names, since "
                      "they name folders",
                      problem.name));
    }
  }
  return all;
}

/// An earlier run's summary of the same problem with the same seed, where it converged.
std::optional<solver::Summary> finished(const fs::path& folder,
                                        const transcription::Problem& problem) {
  try {
    solver::Summary summary = solver::read_summary(folder / "summary.json");
    if (summary.converged() && summary.problem == transcription::describe_problem(problem))
      return summary;
  } catch (const InputError&) {
    return std::nullopt;  // absent, not ours or damaged: solved again and replaced
  }
  return std::nullopt;
}

/// Solves one problem and writes its folder.
solver::Summary solve_one(const Loaded& loaded, const Common& common,
                          const std::shared_ptr<const Executor>& executor = nullptr) {
  const solver::SolvedPlan solved = solve_loaded(loaded, common, executor);
  const fs::path folder = fs::path(common.out) / loaded.problem.name;
  if (!common.out.empty() && !interrupt_requested()) {
    prepare_folder(folder);
    solver::write_plan(solved, folder);
  }
  return solved.summary;
}

/// Solves those problems that have no summary yet, several at a time, each in a process of its own.
/// Where a problem has several starts, these are what runs side by side, and the problems take
/// turns.
void solve_all(const std::vector<Loaded>& all, const CompareOptions& options,
               const std::shared_ptr<const Executor>& executor,
               std::vector<std::optional<solver::Summary>>& summaries) {
  std::vector<std::size_t> open;
  bool several_starts = false;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (summaries[i]) continue;
    open.push_back(i);
    several_starts = several_starts || all[i].problem.solver.starts > 1;
  }

  if (several_starts || (options.common.jobs == 1 && !executor)) {
    for (const std::size_t i : open) {
      const bool of_another = !worker_stage().empty() && worker_stage() != stage_of(all[i].problem);
      if (executor && of_another) continue;
      const auto where = all[i].problem.solver.starts > 1 ? executor : nullptr;
      solver::Summary summary = solve_one(all[i], options.common, where);
      if (interrupt_requested()) return;
      summaries[i] = std::move(summary);
    }
    return;
  }

  TaskOptions tasks;
  tasks.workers = options.common.jobs;
  tasks.notice = notices(options.common);
  tasks.executor = executor;
  tasks.stage = "compare";
  std::string described(version());
  for (const Loaded& loaded : all)
    described += transcription::describe_problem(loaded.problem).dump();
  tasks.fingerprint = fmt::format("compare {:016x}", hash64(described));
  const auto task = [&](int k) {
    return solver::to_json(solve_one(all[open[k]], options.common)).dump();
  };

  const std::vector<TaskResult> results = run_tasks(count_of(open), task, tasks);
  for (std::size_t k = 0; k < open.size(); ++k) {
    const std::string& name = all[open[k]].problem.name;
    if (results[k].state == TaskState::failed)
      throw std::runtime_error(fmt::format("{}: {}", name, results[k].error));
    if (results[k].state == TaskState::done)
      summaries[open[k]] = solver::summary_from_json(Json::parse(results[k].bytes), name);
  }
}

/// Prints and writes what the comparison says; the exit code.
int report(const std::vector<studies::ComparisonRow>& rows, const Common& common) {
  if (!common.out.empty()) studies::write_comparison(rows, common.out);
  if (common.json) {
    print(studies::comparison_json(rows).dump(1) + "\n");
  } else if (!common.quiet) {
    print(report::comparison_text(rows, colours()));
    if (!common.out.empty()) print(fmt::format("written to {}\n", common.out));
  }
  const bool converged = std::all_of(rows.begin(), rows.end(),
                                     [](const auto& row) { return row.summary.converged(); });
  return converged ? kDone : kNotSolved;
}

int run_compare(const CompareOptions& options) {
  const Common& common = options.common;
  if (options.resume && common.out.empty()) {
    throw InputError(
        "--resume: given without --out; allowed: with the --out of the run to go on with");
  }

  const std::vector<Loaded> all = load_all(options);
  check_figures(common);
  if (!common.out.empty()) prepare_folder(common.out);
  // Workers must all see the same list, so that on a cluster its journals tell what is finished.
  const auto executor = make_executor(common, jobs_folder(common.out));
  std::vector<std::optional<solver::Summary>> summaries(all.size());
  for (std::size_t i = 0; i < all.size() && options.resume && !executor; ++i)
    summaries[i] = finished(fs::path(common.out) / all[i].problem.name, all[i].problem);
  solve_all(all, options, executor, summaries);
  clear_progress(common);
  std::vector<studies::ComparisonRow> rows;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (summaries[i])
      rows.push_back(studies::comparison_row(all[i].problem, all[i].robot.planar, *summaries[i]));
  if (rows.size() < all.size()) {
    fmt::print(stderr, "jaculus: interrupted; {} of {} problems are solved{}\n", rows.size(),
               all.size(), common.out.empty() ? "" : ", --resume goes on");
    return kNotSolved;
  }

  const int code = report(rows, common);
  if (executor) remove_jobs(*executor);
  if (common.out.empty()) return code;
  std::vector<report::PlanRecord> plans;
  for (std::size_t i = 0; i < all.size(); ++i)
    plans.push_back(
        report::plan_record(all[i].problem, all[i].robot.planar, rows[i].summary,
                            solver::read_plan_tables(fs::path(common.out) / all[i].problem.name)));
  write_reporting(report::compare_report(plans, rows), common);

  return code;
}

}  // namespace

void add_compare(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand(
      "compare", "Solves several problems and tabulates them against the first.");
  command->footer(
      "Writes compare.json, compare.csv, report.html and a folder for each problem into --out; "
      "exit code 1 where one "
      "did not "
      "converge.\n"
      "Example:\n  jaculus compare problems/leap_tailless.yaml problems/leap_inactive.yaml "
      "problems/leap_inertial.yaml "
      "\\\n"
      "                  problems/leap_tail.yaml --out leaps");

  command->add_option("problems", options->problems, "problem files, the one without tail first")
      ->required();
  add_common(*command, options->common, "folder for the results; nothing is written unless given");
  add_figures(*command, options->common);
  add_executor(*command, options->common);
  command->add_flag("--resume", options->resume,
                    "keep what an interrupted run has finished in --out");
  command->callback([options, &chosen] { chosen = [options] { return run_compare(*options); }; });
}

}  // namespace jaculus::cli
