// jaculus solve: one optimisation.

#include <fmt/format.h>

#include <memory>

#include "cli/plan.h"

namespace jaculus::cli {
namespace {

struct Options {
  Common common;
  std::string problem;
};

int run(const Options& options, const ProblemSolver& solver) {
  const Common& common = options.common;
  const Loaded loaded = load(options.problem, common);
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
  return solved.summary.converged ? kDone : kNotSolved;
}

}  // namespace

void add_solve(CLI::App& app, Action& chosen, const ProblemSolver& solver) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("solve", "Solves one problem and verifies the plan.");
  command->footer(
      "Writes plan.csv, summary.json, timing.json and solution.json into --out; exit code 1 where it did not "
      "converge.\n"
      "Example:\n  jaculus solve problems/leap_tail.yaml --out leap");
  command->add_option("problem", options->problem, "problem file")->required();
  add_common(*command, options->common, "folder for the results; nothing is written unless given");
  command->callback([options, solver, &chosen] { chosen = [options, solver] { return run(*options, solver); }; });
}

}  // namespace jaculus::cli
