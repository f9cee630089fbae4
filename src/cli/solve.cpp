// jaculus solve: one optimisation.

#include <fmt/format.h>

#include <memory>

#include "cli/plan.h"
#include "cli/reporting.h"

namespace jaculus::cli {
namespace {

struct Options {
  Common common;
  std::string problem;
  std::optional<int> starts;  ///< replaces the problem's
};

int run(const Options& options, const ProblemSolver& solver) {
  const Common& common = options.common;
  Loaded loaded = load(options.problem, common);
  check_figures(common);
  if (options.starts) loaded.problem.solver.starts = *options.starts;
  if (!common.out.empty()) prepare_folder(common.out);
  const SolvedProblem solved = solver(loaded, common, progress_line(common, loaded.problem.name));
  clear_progress(common);
  if (!common.out.empty()) write_solved(common.out, solved);
  if (common.json) {
    print(to_json(solved.summary).dump(1) + "\n");
  } else if (!common.quiet) {
    print(to_text(solved.summary, colours()));
    if (!common.out.empty()) print(fmt::format("written to {}\n", common.out));
  }
  if (!common.out.empty()) write_reporting(solve_report(plan_record(loaded, solved.summary, common.out)), common);
  return solved.summary.converged ? kDone : kNotSolved;
}

}  // namespace

void add_solve(CLI::App& app, Action& chosen, const ProblemSolver& solver) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("solve", "Solves one problem and verifies the plan.");
  command->footer(
      "Writes plan.csv, iterations.csv, summary.json, timing.json, solution.json and report.html into --out; exit code "
      "1 where it did not "
      "converge.\n"
      "Example:\n  jaculus solve problems/leap_tail.yaml --out leap");
  command->add_option("problem", options->problem, "problem file")->required();
  command
      ->add_option("--starts", options->starts,
                   "starts, instead of the problem's: its guess, then smooth random ones; --jobs run at a time")
      ->check(whole_number(1, 10000));
  add_common(*command, options->common, "folder for the results; nothing is written unless given");
  add_figures(*command, options->common);
  command->callback([options, solver, &chosen] { chosen = [options, solver] { return run(*options, solver); }; });
}

}  // namespace jaculus::cli
