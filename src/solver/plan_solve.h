#pragma once
// How make_plan comes to a result: starts, feasibility stages, finer meshes.

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "jaculus/solver/ipopt.h"
#include "jaculus/solver/plan.h"

namespace jaculus::solver::detail {

SolverOptions solver_options(const transcription::Problem& problem, const PlanOptions& options);

/// What came of the starts of a problem.
struct SolvedStarts {
  StartFigures figures;  ///< none taken yet
  /// By start: the optima that were found, the best first, each once; where none was, the result
  /// that is to be told of. Never empty.
  std::vector<std::pair<int, NlpResult>> results;
};

/// Solves from the problem's guess, and from smooth random ones where the problem asks for several
/// starts. A random start first goes through a feasibility stage; the problem's own guess does
/// where the solve from it ends with no feasible point nearby although the stage finds one.
SolvedStarts solve_starts(transcription::NonlinearProgram& program,
                          const std::optional<EarlierPlan>& earlier, const PlanOptions& options);

/// Objectives of one start, to be minimised: on the first mesh and on the last one.
struct RefinedStart {
  double first, last;
};

/// Whether an optimum of that objective on the first mesh may be better than the best plan so far
/// once its mesh is refined. Optima come the best first, and a finer mesh keeps an optimum nearly
/// as it is, so none that follows is better, unless it still beats what was taken by enough to pay
/// for another refinement, or finer meshes led what was taken to another optimum: then the order of
/// the first mesh says nothing of theirs.
bool worth_refining(double first, const RefinedStart& best);

/// Solves a program, to the tolerance of the options.
using SolveProgram =
    std::function<NlpResult(transcription::NonlinearProgram&, const SolverOptions&)>;

/// Whether a problem has so many intervals that coarser meshes are the faster way to its plan.
bool is_fine(const transcription::Problem& problem);

/// Solves a fine program by a sequence of meshes, each twice as fine as the one before: the
/// coarsest by `first`, all but the last loosely, each from the one before with its multipliers
/// (prolong.h). Takes as many iterations as the coarsest mesh and few on each that follows, where a
/// fine mesh from a guess takes ever more. Iterations and times are those of all meshes. Not
/// converged, with no iterate, where one of the coarser meshes does not converge.
NlpResult solve_nested(transcription::NonlinearProgram& program, const SolverOptions& solver,
                       const SolveProgram& first);

/// Counts what came earlier as part of a result.
void add_earlier(const NlpResult& earlier, NlpResult& result);

/// Solves again on finer meshes, each time from the plan before, as long as that converges. A finer
/// solve that does not converge leaves the coarser plan and is told in plan.refinement_failure.
void refine_mesh(Plan& plan, transcription::Problem problem, const model::PlanarModel& model,
                 const PlanOptions& options);

}  // namespace jaculus::solver::detail
