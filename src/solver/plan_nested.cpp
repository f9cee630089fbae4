// A solve on a fine mesh by way of coarser ones.

#include <algorithm>

#include "jaculus/core/interrupt.h"
#include "solver/plan_solve.h"
#include "solver/prolong.h"

namespace jaculus::solver::detail {
namespace {

using transcription::NonlinearProgram;
using transcription::Problem;

// Intervals of the longest phase: up to so many a mesh is solved directly, ...
constexpr int kDirect = 40;
// ... and the coarsest of a sequence has no more than this.
constexpr int kCoarsest = 20;

// Coarse meshes end at a barrier at which limits are still a little way off: their set of active
// limits is not the fine mesh's, and an interior point changes its mind only while it is inside.
constexpr double kCoarseTolerance = 1e-3;
// First barrier over the start's mean complementarity. This and the tolerance are the best of
// eleven settings on four leaps (docs/speed.md), tried on nothing else.
constexpr double kAbove = 3.0;

// A bound on what a poor start may cost; on no problem measured does it gain anything.
constexpr int kPatience = 100;

int longest(const Problem& problem) {
  int intervals = 0;
  for (const transcription::PhaseSpec& phase : problem.phases)
    intervals = std::max(intervals, phase.intervals);
  return intervals;
}

/// The problem with its intervals joined by twos. Limits hold at the same times as before.
Problem coarser(Problem problem) {
  for (transcription::PhaseSpec& phase : problem.phases) {
    std::vector<double> mesh =
        phase.mesh.empty() ? std::vector<double>(phase.intervals, 1.0) : phase.mesh;
    if (phase.stated_mesh.empty()) phase.stated_mesh = mesh;
    std::vector<double> joined;
    for (std::size_t k = 0; k < mesh.size(); k += 2)
      joined.push_back(mesh[k] + (k + 1 < mesh.size() ? mesh[k + 1] : 0.0));
    phase.intervals = count_of(joined);
    phase.mesh = std::move(joined);
  }
  return problem;
}

/// From a prolonged start; where that leads nowhere soon, from its variables as from any guess.
NlpResult solve_prolonged(NonlinearProgram& program, const Start& start,
                          const SolverOptions& solver) {
  SolverOptions near = prolonged_options(solver, program, start, kAbove);
  near.max_iterations = std::min(near.max_iterations, kPatience);
  const NlpResult first = solve_nlp(program, start, near);
  if (first.converged() || interrupt_requested()) return first;

  NlpResult second = solve_nlp(program, {start.x}, solver);
  add_earlier(first, second);
  return second;
}

}  // namespace

void add_earlier(const NlpResult& earlier, NlpResult& result) {
  result.iterations += earlier.iterations;
  result.feasibility_iterations += earlier.feasibility_iterations;
  result.wall_seconds.total += earlier.wall_seconds.total;
  result.wall_seconds.functions += earlier.wall_seconds.functions;
  result.wall_seconds.linear_solver += earlier.wall_seconds.linear_solver;
}

bool is_fine(const Problem& problem) { return longest(problem) > kDirect; }

NlpResult solve_nested(NonlinearProgram& program, const SolverOptions& solver,
                       const SolveProgram& first) {
  std::vector<Problem> problems;  // ever coarser
  for (Problem problem = program.problem(); longest(problem) > kCoarsest;)
    problems.push_back(problem = coarser(std::move(problem)));

  SolverOptions loose = solver;
  loose.tolerance = std::max(solver.tolerance, kCoarseTolerance);
  const auto build = [&](const Problem& problem) {
    return std::make_unique<NonlinearProgram>(problem, program.equations().model());
  };

  auto mesh = build(problems.back());
  NlpResult result = first(*mesh, loose);
  problems.pop_back();
  while (result.converged() && !interrupt_requested()) {
    const bool last = problems.empty();
    auto finer = last ? nullptr : build(problems.back());
    NonlinearProgram& next = last ? program : *finer;
    NlpResult own = solve_prolonged(next, prolong(*mesh, result, next), last ? solver : loose);
    add_earlier(result, own);
    if (last) return own;

    result = std::move(own);
    mesh = std::move(finer);
    problems.pop_back();
  }

  // The iterate is of another mesh than the program's.
  if (result.converged()) result.status = Status::interrupted;
  result.set_iterate({});
  return result;
}

}  // namespace jaculus::solver::detail
