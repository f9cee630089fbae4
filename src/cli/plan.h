#pragma once
// A solved problem as commands see it, and its files.

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/command.h"
#include "jaculus/report/compare_report.h"
#include "jaculus/report/plan_report.h"
#include "jaculus/report/summary.h"
#include "jaculus/solver/result.h"
#include "jaculus/trajectory/trajectory.h"

namespace jaculus::cli {

struct SolvedProblem {
  Summary summary;
  std::optional<Trajectory> trajectory;  ///< the plan, or the last iterate where the solve did not converge
  nlohmann::ordered_json solution;       ///< primal and dual, to resume or warm-start; null where there is none
  std::vector<IterationInfo> history;    ///< every iteration of the solver
  nlohmann::ordered_json timing;         ///< wall seconds, apart from everything that is the same on every run
};

using Progress = std::function<void(const IterationInfo&)>;
/// Solves a loaded problem. Numerical failure is a status in the summary.
using ProblemSolver = std::function<SolvedProblem(const Loaded&, const Common&, const Progress&)>;

/// The solver of the library.
SolvedProblem solve_loaded(const Loaded& loaded, const Common& common, const Progress& progress);

/// plan.csv, iterations.csv, solution.json, timing.json, summary.json, the last one last: where it is, the others are.
void write_solved(const std::filesystem::path& folder, const SolvedProblem& solved);

/// One line on standard error that is rewritten at every iteration; nothing where `common` shows no progress.
Progress progress_line(const Common& common, const std::string& name);

/// What the report of a plan needs; `folder` holds what write_solved() wrote.
PlanRecord plan_record(const Loaded& loaded, const Summary& summary, const std::filesystem::path& folder);

/// The row of a comparison.
ComparisonRow comparison_row(const Loaded& loaded, const Summary& summary);

void add_solve(CLI::App& app, Action& chosen, const ProblemSolver& solver);
void add_compare(CLI::App& app, Action& chosen, const ProblemSolver& solver);

}  // namespace jaculus::cli
