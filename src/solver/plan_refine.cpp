// Finer meshes, on request.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <optional>
#include <string_view>

#include "jaculus/core/interrupt.h"
#include "solver/plan_solve.h"
#include "solver/prolong.h"

namespace jaculus::solver::detail {
namespace {

/// What the plan has come to on its present mesh.
MeshRound mesh_round(Plan& plan, int iterations) {
  const transcription::NonlinearProgram& program = *plan.program;
  const transcription::Layout& layout = program.layout();
  MeshRound round;
  for (const transcription::PhaseBlock& phase : layout.phases)
    round.intervals.push_back(phase.last_interval - phase.first_interval + 1);
  round.objective = program.problem().maximise ? -plan.result.objective : plan.result.objective;
  round.iterations = iterations;
  round.duration = 0.0;
  const Vector& x = plan.result.x();
  for (const transcription::PhaseBlock& phase : layout.phases) round.duration += x[phase.duration];
  const int forward = program.equations().model().coordinate_index("x");
  if (forward >= 0) round.final_velocity = x[layout.nodes.back().v + forward];
  round.interval_error = interval_errors(*plan.program, x).maxCoeff();
  return round;
}

/// Whether each interval is too long: its error is above the tolerance, or a limit is passed within
/// it.
std::vector<bool> too_long(const Plan& plan, const transcription::RefinementSpec& refinement) {
  const Vector& x = plan.result.x();
  const Vector errors = interval_errors(*plan.program, x);
  std::vector<bool> split;
  for (const double error : errors)
    split.push_back(refinement.tolerance == 0.0 || error > refinement.tolerance);
  if (refinement.limits == 0.0) return split;

  const Vector passed = verify_plan(*plan.program, x).interval_excess;
  for (int k = 0; k < passed.size(); ++k) split[k] = split[k] || passed[k] > refinement.limits;
  return split;
}

/// Halves every interval that is too long; false where none is.
bool refine(transcription::Problem& problem, const transcription::Layout& layout,
            const std::vector<bool>& halved) {
  bool any = false;
  for (std::size_t p = 0; p < problem.phases.size(); ++p) {
    const transcription::PhaseBlock& block = layout.phases[p];
    transcription::PhaseSpec& phase = problem.phases[p];

    // Counts of points in the file go on meaning the file's grid.
    if (phase.stated_mesh.empty())
      phase.stated_mesh =
          phase.mesh.empty() ? std::vector<double>(phase.intervals, 1.0) : phase.mesh;

    std::vector<double> mesh;
    for (int k = block.first_interval; k <= block.last_interval; ++k) {
      const double fraction = layout.intervals[k].fraction;
      const bool split = halved[k];
      mesh.insert(mesh.end(), split ? 2 : 1, split ? 0.5 * fraction : fraction);
      any = any || split;
    }

    phase.intervals = count_of(mesh);
    phase.mesh = mesh;
  }
  return any;
}

/// The start is nearly optimal: stay close to it and to its active bounds. `barrier`: the first
/// one.
SolverOptions near_options(const transcription::Problem& problem, const PlanOptions& options,
                           const char* barrier) {
  SolverOptions near = solver_options(problem, options);
  near.ipopt = {{"mu_init", barrier},
                {"bound_push", "1e-8"},
                {"bound_frac", "1e-8"},
                {"slack_bound_push", "1e-8"},
                {"slack_bound_frac", "1e-8"}};
  return near;
}

/// Whether a plan holds its limits within intervals too, as far as a refinement asks.
bool holds_limits(const Plan& plan, const transcription::RefinementSpec& refinement) {
  if (refinement.limits == 0.0) return true;
  const Vector passed = verify_plan(*plan.program, plan.result.x()).interval_excess;
  return passed.size() == 0 || passed.maxCoeff() <= refinement.limits;
}

/// A finer mesh can do nearly all that a coarser one can, unless that passes limits between its
/// nodes: where it does much worse the solver has gone to another optimum.
bool in_worse_optimum(const NlpResult& coarse, const NlpResult& fine) {
  constexpr double kWorse = 0.01;
  return fine.objective > coarse.objective + kWorse * std::abs(coarse.objective);
}

/// The plan on a finer mesh, from the plan before with its multipliers. Where that ends worse or
/// nowhere, as from any guess, then with ever smaller first barriers, which stay close; the best of
/// those that converge.
NlpResult solve_finer(Plan& plan, transcription::NonlinearProgram& finer,
                      const PlanOptions& options) {
  // A converged plan lies so near its limits that the mesh's others are hard to take up; a barrier
  // above its own makes room. Of 1, 3, 10, 30 on four leaps (docs/speed.md).
  constexpr double kAbove = 10.0;
  const SolverOptions plain = solver_options(finer.problem(), options);
  const Start prolonged = prolong(*plan.program, plan.result, finer);
  NlpResult result;
  std::optional<NlpResult> best;  // that converged
  int before = 0;
  for (const char* barrier : {"prolonged", "", "1e-4", "1e-6", "1e-8"}) {
    const std::string_view way = barrier;
    if (way == "prolonged")
      result = solve_nlp(finer, prolonged,
                         prolonged_options(plain, kAbove * mean_complementarity(finer, prolonged)));
    else if (way.empty())
      result = solve_nlp(finer, {prolonged.x}, plain);
    else
      result = solve_nlp(finer, {prolonged.x}, near_options(finer.problem(), options, barrier));
    result.iterations += before;
    before = result.iterations;
    if (result.converged() && (!best || result.objective < best->objective)) best = result;
    const bool good = result.converged() && !in_worse_optimum(plan.result, result);
    if (good || interrupt_requested()) break;
  }
  if (!best) return result;
  best->iterations = before;
  return *best;
}

}  // namespace

void refine_mesh(Plan& plan, transcription::Problem problem, const model::PlanarModel& model,
                 const PlanOptions& options) {
  if (!plan.converged() || problem.refinement.max_rounds == 0) return;
  plan.mesh_rounds.push_back(mesh_round(plan, plan.result.iterations));
  for (int number = 1; number <= problem.refinement.max_rounds; ++number) {
    if (!refine(problem, plan.program->layout(), too_long(plan, problem.refinement))) return;
    auto finer = std::make_unique<transcription::NonlinearProgram>(problem, model);
    NlpResult result = solve_finer(plan, *finer, options);

    const bool astray =
        in_worse_optimum(plan.result, result) && holds_limits(plan, problem.refinement);
    if (!result.converged() || astray) {
      std::vector<int> intervals;
      for (const transcription::PhaseSpec& phase : problem.phases)
        intervals.push_back(phase.intervals);
      plan.refinement_failure = fmt::format(
          "round {} of the mesh refinement, {} intervals, ended '{}'{}; the plan is that before it",
          number, fmt::join(intervals, " + "), to_string(result.status),
          result.converged() ? " in a worse local optimum" : "");
      return;
    }

    const int own = result.iterations;
    result.iterations += plan.result.iterations;
    result.feasibility_iterations = plan.result.feasibility_iterations;
    plan.result = std::move(result);
    plan.program = std::move(finer);
    ++plan.refinements;
    plan.mesh_rounds.push_back(mesh_round(plan, own));
  }
}

}  // namespace jaculus::solver::detail
