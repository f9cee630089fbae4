#include "jaculus/solver/plan.h"

#include "jaculus/core/interrupt.h"
#include "solver/plan_solve.h"

namespace jaculus {
namespace {

constexpr int kMostViolations = 12;

void diagnose(Plan& plan) {
  Programme& programme = *plan.programme;
  const Vector x = plan.result.last_iterate();
  if (x.size() != programme.variables()) return;
  if (auto ranked = ranked_violations(programme, x, kMostViolations, programme.problem().solver.tolerance))
    plan.violations = std::move(*ranked);
  if (interrupt_requested() || plan.result.status == Status::stopped) return;
  ElasticOptions elastic;
  elastic.solver.max_iterations = programme.problem().solver.max_iterations;
  elastic.solver.linear_solver = programme.problem().solver.linear_solver;
  plan.conflict = find_conflict(programme, x, elastic);
}

}  // namespace

bool EarlierPlan::fits(const Programme& programme) const {
  if (static_cast<int>(variables.size()) != programme.variables() || static_cast<int>(rows.size()) != programme.rows())
    return false;
  for (int i = 0; i < programme.variables(); ++i)
    if (variables[static_cast<std::size_t>(i)] != programme.variable_name(i)) return false;
  for (int i = 0; i < programme.rows(); ++i)
    if (rows[static_cast<std::size_t>(i)] != programme.row_name(i)) return false;
  return true;
}

Plan make_plan(const Problem& problem, const PlanarModel& model, const PlanOptions& options) {
  const PlanarModel planned = planning_model(problem, model);
  Plan plan;
  plan.programme = std::make_unique<Programme>(problem, planned);
  std::optional<EarlierPlan> earlier;
  if (problem.guess.kind == "file") earlier = read_earlier_plan(problem.guess.file, planned);
  plan.result.conflicts = bound_conflicts(*plan.programme);
  if (!plan.result.conflicts.empty()) {
    plan.result.status = Status::contradictory_bounds;
    plan.result.message = "bounds that nothing can satisfy; nothing was run";
    for (const BoundConflict& c : plan.result.conflicts)
      plan.violations.push_back({false, 0, c.name, c.unit, kNaN, c.lower, c.upper, c.lower - c.upper, kNaN});
    return plan;
  }
  if (earlier && !earlier->fits(*plan.programme)) plan.notes = guess_gaps(*plan.programme, earlier->trajectory);
  plan.result = detail::solve_starts(plan, earlier, options);
  detail::refine_mesh(plan, problem, planned, options);
  const Vector x = plan.result.last_iterate();
  if (x.size() == plan.programme->variables() && plan.programme->evaluate_at(x)) {
    plan.trajectory = to_trajectory(*plan.programme, x);
    plan.verification = verify_plan(*plan.programme, x);
  }
  if (plan.converged()) {
    plan.limits = active_limits(*plan.programme, plan.result);
    price_limits(plan);
  } else {
    diagnose(plan);
  }
  return plan;
}

}  // namespace jaculus
