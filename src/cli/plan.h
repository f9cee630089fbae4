#pragma once
// What `solve` and `compare` share: solving a loaded problem with its progress on the terminal.

#include <functional>

#include "cli/command.h"
#include "jaculus/solver/plan_files.h"
#include "jaculus/solver/result.h"

namespace jaculus::cli {

/// Solves a loaded problem, with a line on standard error that is rewritten at every iteration
/// where `common` shows progress. Numerical failure is a status in the summary.
solver::SolvedPlan solve_loaded(const Loaded& loaded, const Common& common);

void add_solve(CLI::App& app, Action& chosen);
void add_compare(CLI::App& app, Action& chosen);

}  // namespace jaculus::cli
