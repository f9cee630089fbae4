#include "solver/plan_solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/journal.h"
#include "jaculus/transcription/describe.h"

namespace jaculus::solver::detail {
namespace {

// scaled: more than this in the way of a stage is a conflict, not a bad start
constexpr double kNearlyFeasible = 1e-2;

/// Start number `index`: the problem's own guess first, then smooth random ones.
Start make_start(transcription::NonlinearProgram& program,
                 const std::optional<EarlierPlan>& earlier, int index, std::uint64_t seed) {
  transcription::GuessSpec spec = program.problem().guess;
  if (index > 0) spec.kind = "random";
  if (index == 0 && earlier && earlier->fits(program)) return {earlier->x, earlier->duals};
  return {
      transcription::initial_guess(program, spec, seed, earlier ? &earlier->trajectory : nullptr)};
}

Conflict feasibility_stage(transcription::NonlinearProgram& program, const Vector& x,
                           const SolverOptions& solver) {
  ElasticOptions elastic;
  elastic.proximity = kStageProximity;
  elastic.solver = solver;
  return find_conflict(program, x, elastic);
}

/// Counts what a stage took as part of the solve that went on from it.
void add_stage(const Conflict& stage, NlpResult& result) {
  result.feasibility_iterations = stage.iterations;
  result.iterations += stage.iterations;
  result.wall_seconds.total += stage.wall_seconds.total;
  result.wall_seconds.functions += stage.wall_seconds.functions;
  result.wall_seconds.linear_solver += stage.wall_seconds.linear_solver;
}

NlpResult solve_after_stage(transcription::NonlinearProgram& program, const Vector& x,
                            const SolverOptions& solver) {
  const Conflict stage = feasibility_stage(program, x, solver);
  const bool stopped =
      stage.status == Status::interrupted || stage.status == Status::stopped || stage.x.size() == 0;
  NlpResult result = solve_nlp(program, {stopped ? x : stage.x}, solver);
  add_stage(stage, result);
  return result;
}

/// A second try from the same start through a feasibility stage, where that leads anywhere; else
/// the first result.
NlpResult try_again(transcription::NonlinearProgram& program, const Vector& x,
                    const SolverOptions& solver, NlpResult first) {
  const Conflict stage = feasibility_stage(program, x, solver);
  const bool promising = stage.status == Status::optimal || stage.status == Status::acceptable ||
                         stage.status == Status::iteration_limit;
  if (!promising || (!stage.relaxed.empty() && stage.relaxed.front().scaled > kNearlyFeasible))
    return first;
  NlpResult second = solve_nlp(program, {stage.x}, solver);
  if (!second.converged()) return first;
  add_stage(stage, second);
  add_earlier(first, second);
  second.feasibility_iterations += first.iterations;
  return second;
}

/// From start number `index` on the program's own mesh.
NlpResult solve_directly(transcription::NonlinearProgram& program,
                         const std::optional<EarlierPlan>& earlier, int index, std::uint64_t seed,
                         const SolverOptions& solver) {
  const Start start = make_start(program, earlier, index, seed);
  if (index > 0 || program.problem().guess.kind == "random")
    return solve_after_stage(program, start.x, solver);
  NlpResult result = solve_nlp(program, start, solver);
  const bool search_failed =
      result.status == Status::infeasible || result.status == Status::stalled;
  return search_failed ? try_again(program, start.x, solver, std::move(result)) : result;
}

/// By way of coarser meshes where the program's is fine, unless they lead nowhere or its very
/// solution is at hand.
NlpResult solve_start(transcription::NonlinearProgram& program,
                      const std::optional<EarlierPlan>& earlier, int index, std::uint64_t seed,
                      const SolverOptions& solver) {
  const auto directly = [&](transcription::NonlinearProgram& mesh, const SolverOptions& options) {
    return solve_directly(mesh, earlier, index, seed, options);
  };
  const bool at_hand = index == 0 && earlier && earlier->fits(program);
  if (at_hand || !is_fine(program.problem())) return directly(program, solver);

  NlpResult nested = solve_nested(program, solver, directly);
  if (nested.converged() || interrupt_requested()) return nested;
  NlpResult direct = directly(program, solver);
  add_earlier(nested, direct);
  return direct;
}

/// Starts that an interrupt didn't keep from their end; failing is an end too.
int ended_of(const MultiStart& all) {
  return static_cast<int>(
      std::count_if(all.starts.begin(), all.starts.end(), [](const StartOutcome& start) {
        const bool stopped =
            start.task == TaskState::done &&
            (start.result.status == Status::interrupted || start.result.status == Status::stopped);
        return start.task != TaskState::cancelled && !stopped;
      }));
}

/// Where no start ran to its end: why.
NlpResult no_result(const MultiStart& all) {
  NlpResult none;
  none.status = interrupt_requested() ? Status::interrupted : Status::failed;
  none.message =
      interrupt_requested() ? "interrupted before any start ended" : "no start ran to its end";
  for (const StartOutcome& start : all.starts) {
    if (!start.error.empty()) none.message += ": " + start.error;
    if (!start.error.empty()) break;
  }
  return none;
}

}  // namespace

SolverOptions solver_options(const transcription::Problem& problem, const PlanOptions& options) {
  SolverOptions solver;
  solver.tolerance = problem.solver.tolerance;
  solver.row_tolerance = std::min(1e-6, problem.solver.tolerance);
  solver.max_iterations = problem.solver.max_iterations;
  solver.linear_solver = problem.solver.linear_solver;
  if (options.progress) {
    solver.progress = [report = options.progress](const IterationInfo& info) {
      report(info);
      return true;
    };
  }
  return solver;
}

bool worth_refining(double first, const RefinedStart& best) {
  constexpr double kBetter = 0.01;  // of the objective: less isn't worth another refinement
  const bool fell = best.last > best.first + kBetter * std::abs(best.first);
  return fell || first < best.last - kBetter * std::abs(best.last);
}

SolvedStarts solve_starts(transcription::NonlinearProgram& program,
                          const std::optional<EarlierPlan>& earlier, const PlanOptions& options) {
  const transcription::SolverSpec& spec = program.problem().solver;
  const std::uint64_t seed = spec.seed;
  SolverOptions solver = solver_options(program.problem(), options);
  SolvedStarts solved;
  if (spec.starts <= 1) {
    solved.results.emplace_back(0, solve_start(program, earlier, 0, task_seed(seed, 0), solver));
    return solved;
  }

  MultiStartOptions multi;
  multi.seed = seed;
  multi.tasks.workers = options.jobs;
  multi.tasks.progress = options.starts_progress;
  multi.tasks.notice = options.notice;
  multi.tasks.executor = options.executor;
  multi.tasks.stage = options.stage;
  multi.tasks.fingerprint = fmt::format(
      "starts {:016x}",
      hash64(transcription::describe_problem(program.problem()).dump() + std::string(version())));
  solver.progress = {};  // several processes at a time would talk at once

  MultiStart all = multi_start(
      spec.starts,
      [&](int index, std::uint64_t own) {
        return solve_start(program, earlier, index, own, solver);
      },
      multi);

  solved.figures.count = spec.starts;
  solved.figures.ended = ended_of(all);
  solved.figures.converged = all.converged;
  solved.figures.near_best = static_cast<int>(std::lround(all.near_share * spec.starts));
  for (const int start : optima(all, multi.tie))
    solved.results.emplace_back(start, std::move(all.starts[start].result));
  if (!solved.results.empty()) return solved;

  if (all.least_bad >= 0)
    solved.results.emplace_back(all.least_bad, std::move(all.starts[all.least_bad].result));
  else
    solved.results.emplace_back(0, no_result(all));
  return solved;
}

}  // namespace jaculus::solver::detail
