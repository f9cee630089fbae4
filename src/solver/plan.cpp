#include "jaculus/solver/plan.h"

#include <cmath>

#include "jaculus/core/interrupt.h"
#include "solver/plan_solve.h"

namespace jaculus::solver {
namespace {

void diagnose(Plan& plan) {
  transcription::NonlinearProgram& program = *plan.program;
  const Vector x = plan.result.last_iterate();
  if (x.size() != program.variables()) return;
  if (auto ranked = ranked_violations(program, x, program.rows() + program.variables(),
                                      program.problem().solver.tolerance))
    plan.violations = std::move(*ranked);
  if (interrupt_requested() || plan.result.status == Status::stopped) return;
  ElasticOptions elastic;
  elastic.solver.max_iterations = program.problem().solver.max_iterations;
  elastic.solver.linear_solver = program.problem().solver.linear_solver;
  plan.conflict = find_conflict(program, x, elastic);
}

/// Limits are held to what the refinement asks for, else to the defaults.
VerifyOptions verification_of(const transcription::Problem& problem) {
  VerifyOptions options;
  if (problem.refinement.limits > 0.0) options.between = options.remark = problem.refinement.limits;
  return options;
}

/// The plan from one result of a program: on finer meshes, where they are asked for, and verified.
Plan finish(std::unique_ptr<transcription::NonlinearProgram> program,
            const transcription::Problem& problem, const model::PlanarModel& planned,
            NlpResult result, const PlanOptions& options) {
  Plan plan;
  plan.program = std::move(program);
  plan.result = std::move(result);
  detail::refine_mesh(plan, problem, planned, options);

  const Vector x = plan.result.last_iterate();
  if (x.size() != plan.program->variables() || !plan.program->evaluate_at(x)) return plan;
  plan.trajectory = transcription::to_trajectory(*plan.program, x);
  plan.verification = verify_plan(*plan.program, x, verification_of(problem));
  return plan;
}

/// Of all optima that the starts of a program found the best whose plan holds between nodes, as it
/// is on its last mesh, for finer ones may have led it to another optimum; where none's holds, the
/// best.
Plan best_verified(std::unique_ptr<transcription::NonlinearProgram> program,
                   const std::optional<EarlierPlan>& earlier, const transcription::Problem& problem,
                   const model::PlanarModel& planned, const PlanOptions& options) {
  detail::SolvedStarts solved = detail::solve_starts(*program, earlier, options);
  std::optional<Plan> taken;
  std::optional<detail::RefinedStart> best;  // of `taken`, where that holds
  std::vector<int> passed_over;

  for (auto& [start, result] : solved.results) {
    if (taken && interrupt_requested()) break;
    const double first = result.objective;
    if (best && !detail::worth_refining(first, *best)) break;

    if (!program) program = std::make_unique<transcription::NonlinearProgram>(problem, planned);
    Plan plan = finish(std::move(program), problem, planned, std::move(result), options);
    const bool holds = plan.verification && plan.verification->passed;
    const bool better = holds && (!best || plan.result.objective < best->last);
    if (!holds) passed_over.push_back(start);
    if (!better && taken) continue;
    plan.starts = solved.figures;
    plan.starts.best = start;
    if (holds) plan.starts.passed_over = passed_over;
    taken = std::move(plan);
    if (holds) best = {first, taken->result.objective};
  }

  return std::move(*taken);
}

}  // namespace

bool EarlierPlan::fits(const transcription::NonlinearProgram& program) const {
  if (count_of(variables) != program.variables() || count_of(rows) != program.rows()) return false;
  for (int i = 0; i < program.variables(); ++i)
    if (variables[i] != program.variable_name(i)) return false;
  for (int i = 0; i < program.rows(); ++i)
    if (rows[i] != program.row_name(i)) return false;
  return true;
}

Plan make_plan(const transcription::Problem& problem, const model::PlanarModel& model,
               const PlanOptions& options) {
  const model::PlanarModel planned = transcription::planning_model(problem, model);
  Plan plan;
  plan.program = std::make_unique<transcription::NonlinearProgram>(problem, planned);

  std::optional<EarlierPlan> earlier;
  if (problem.guess.kind == "file") earlier = read_earlier_plan(problem.guess.file, planned);

  plan.result.conflicts = bound_conflicts(*plan.program);
  if (!plan.result.conflicts.empty()) {
    plan.result.status = Status::contradictory_bounds;
    plan.result.message = "bounds that nothing can satisfy; nothing was run";
    for (const BoundConflict& c : plan.result.conflicts)
      plan.violations.push_back(
          {false, 0, c.name, c.unit, kNaN, c.lower, c.upper, c.lower - c.upper, kNaN});
    return plan;
  }

  std::vector<std::string> notes;
  if (earlier && !earlier->fits(*plan.program))
    notes = transcription::guess_gaps(*plan.program, earlier->trajectory);
  plan = best_verified(std::move(plan.program), earlier, problem, planned, options);
  plan.notes = std::move(notes);

  if (plan.converged()) {
    plan.limits = active_limits(*plan.program, plan.result);
    find_sensitivities(plan);
  } else {
    diagnose(plan);
  }

  return plan;
}

}  // namespace jaculus::solver
