// jaculus solve: one optimisation.

#include <fmt/format.h>

#include <memory>

#include "cli/plan.h"
#include "cli/reporting.h"
#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/report/plan_report.h"

namespace jaculus::cli {
namespace {

struct SolveOptions {
  Common common;
  std::string problem;
  std::optional<int> starts;  ///< replaces the problem's
  ProblemChanges changes;
  bool resume = false;
};

std::shared_ptr<const Executor> executor_of(const SolveOptions& options, const Loaded& loaded) {
  auto executor = make_executor(options.common, jobs_folder(options.common.out));
  if (executor && loaded.problem.solver.starts <= 1)
    throw InputError("--executor slurm: given for one start; allowed: with --starts 2 or more");
  if (!executor && options.resume)
    throw InputError("--resume: given without --executor slurm; allowed: with it");
  return executor;
}

int run_solve(const SolveOptions& options) {
  const Common& common = options.common;
  Loaded loaded = load(options.problem, common, options.changes);
  check_figures(common);
  if (options.starts) loaded.problem.solver.starts = *options.starts;
  const auto executor = executor_of(options, loaded);
  if (!common.out.empty()) prepare_folder(common.out);
  const solver::SolvedPlan solved = solve_loaded(loaded, common, executor);
  clear_progress(common);
  if (!common.out.empty()) solver::write_plan(solved, common.out);
  if (common.json) {
    print(solver::to_json(solved.summary).dump(1) + "\n");
  } else if (!common.quiet) {
    print(report::summary_text(solved.summary, colours()));
    if (!common.out.empty()) print(fmt::format("written to {}\n", common.out));
  }
  if (!common.out.empty()) {
    const report::PlanRecord record = report::plan_record(
        loaded.problem, loaded.robot.planar, solved.summary, solver::read_plan_tables(common.out));
    write_reporting(report::solve_report(record), common);
  }
  if (executor && !interrupt_requested()) remove_jobs(*executor);
  return solved.summary.converged() && !interrupt_requested() ? kDone : kNotSolved;
}

}  // namespace

void add_solve(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<SolveOptions>();
  CLI::App* command = app.add_subcommand("solve", "Solves one problem and verifies the plan.");
  command->footer(
      "Writes plan.csv, iterations.csv, summary.json, timing.json, solution.json and report.html "
      "into --out; exit code "
      "1 where it did not "
      "converge.\n"
      "Example:\n  jaculus solve problems/leap_tail.yaml --out leap");
  command->add_option("problem", options->problem, "problem file")->required();

  command
      ->add_option("--starts", options->starts,
                   "starts, instead of the problem's: its guess, then smooth random ones; --jobs "
                   "run at a time")
      ->check(whole_number(1, 10000));
  command->add_option("--robot", options->changes.robot,
                      "a robot's folder or name, instead of the problem's");
  command->add_option("--override", options->changes.overrides,
                      "PATH=VALUE of a model value, over the problem's: attach.tail.kind=none; "
                      "`jaculus check ROBOT` lists the paths");
  add_common(*command, options->common, "folder for the results; nothing is written unless given");
  add_figures(*command, options->common);
  add_executor(*command, options->common);
  command->add_flag("--resume", options->resume,
                    "go on with the starts that an interrupted run on Slurm has finished in --out");
  command->callback([options, &chosen] { chosen = [options] { return run_solve(*options); }; });
}

}  // namespace jaculus::cli
