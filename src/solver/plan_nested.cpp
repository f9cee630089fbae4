// A solve on a fine mesh by way of coarser ones.

#include <fmt/format.h>

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

// The way of the barrier. A product of slack and multiplier goes with the interval length
// (prolong.h), so what is one point of the central path to all meshes is half the barrier on a mesh
// twice as fine. Coarse meshes end at kBarrier, less on each finer one by their lengths and by
// kAhead, to within kLoose of it; the last one goes on to the tolerance. Chosen on five leaps
// (docs/speed.md).
constexpr double kBarrier = 1e-3;
constexpr double kAhead = 0.5;
constexpr double kLoose = 10.0;
// Ipopt's power of 1.5 goes over two decades at once there, which a fine mesh's many limits take
// up only in short steps.
constexpr const char* kPower = "1.2";

// A bound on what a poor start may cost; on no problem measured does it gain anything.
constexpr int kPatience = 100;

int longest(const Problem& problem) {
  int intervals = 0;
  for (const transcription::PhaseSpec& phase : problem.phases)
    intervals = std::max(intervals, phase.intervals);
  return intervals;
}

/// The problem with its intervals joined by twos. Points that a limit leaves out are counted on the
/// coarse mesh: the time of a fine mesh's last interval is too short for its torques.
Problem coarser(Problem problem) {
  for (transcription::PhaseSpec& phase : problem.phases) {
    std::vector<double> mesh =
        phase.mesh.empty() ? std::vector<double>(phase.intervals, 1.0) : phase.mesh;
    std::vector<double> joined;
    for (std::size_t k = 0; k < mesh.size(); k += 2)
      joined.push_back(mesh[k] + (k + 1 < mesh.size() ? mesh[k + 1] : 0.0));
    phase.intervals = count_of(joined);
    phase.mesh = phase.stated_mesh = std::move(joined);
  }
  return problem;
}

/// Options for the barrier problem alone, to which coarse meshes are solved.
SolverOptions at_barrier(SolverOptions solver, double barrier) {
  solver.tolerance = std::max(solver.tolerance, kLoose * barrier);
  solver.ipopt["mu_target"] = fmt::format("{:.17g}", barrier);
  return solver;
}

/// Options for the last mesh, `share` as long in its intervals as the coarsest. Products of slack
/// and multiplier are as many more as intervals are shorter, and what they keep from the objective
/// is their sum.
SolverOptions to_the_end(SolverOptions solver, double share) {
  solver.ipopt["mu_superlinear_decrease_power"] = kPower;
  solver.ipopt["compl_inf_tol"] = fmt::format("{:.17g}", share * solver.tolerance);
  return solver;
}

/// From a prolonged start; where that leads nowhere soon, from its variables as from any guess.
NlpResult solve_prolonged(NonlinearProgram& program, const Start& start,
                          const SolverOptions& solver, double barrier) {
  SolverOptions near = prolonged_options(solver, barrier);
  near.max_iterations = std::min(near.max_iterations, kPatience);
  const NlpResult first = solve_nlp(program, start, near);
  if (first.converged() || interrupt_requested()) return first;

  NlpResult second = solve_nlp(program, {start.x}, solver);
  add_earlier(first, second);
  return second;
}

int intervals(const NonlinearProgram& program) { return count_of(program.layout().intervals); }

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

  const auto build = [&](const Problem& problem) {
    return std::make_unique<NonlinearProgram>(problem, program.equations().model());
  };

  auto mesh = build(problems.back());
  const double coarsest = intervals(*mesh);
  SolverOptions adaptive = at_barrier(solver, kBarrier);
  adaptive.ipopt["mu_strategy"] = "adaptive";
  NlpResult result = first(*mesh, adaptive);
  problems.pop_back();
  for (double ahead = kAhead; result.converged() && !interrupt_requested(); ahead *= kAhead) {
    const bool last = problems.empty();
    auto finer = last ? nullptr : build(problems.back());
    NonlinearProgram& next = last ? program : *finer;

    const double share = coarsest / intervals(next), barrier = kBarrier * share * ahead;
    NlpResult own =
        solve_prolonged(next, prolong(*mesh, result, next),
                        last ? to_the_end(solver, share) : at_barrier(solver, barrier), barrier);
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
