#pragma once
// What `solve` and `compare` share: solving a loaded problem with its progress on the terminal.

#include <functional>

#include "cli/command.h"
#include "jaculus/solver/plan_files.h"
#include "jaculus/solver/result.h"

namespace jaculus::cli {

/// Solves a loaded problem, with a line on standard error that is rewritten at every iteration
/// where `common` shows progress. Numerical failure is a status in the summary. Several starts run
/// on the executor, where there is one.
solver::SolvedPlan solve_loaded(const Loaded& loaded, const Common& common,
                                const std::shared_ptr<const Executor>& executor = nullptr);

/// What the starts of a problem are called among the lists of a command.
std::string stage_of(const transcription::Problem& problem);

void add_solve(CLI::App& app, Action& chosen);
void add_compare(CLI::App& app, Action& chosen);

}  // namespace jaculus::cli
