#include "jaculus/solver/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"

namespace jaculus {
namespace {

constexpr int kMostViolations = 12;

SolverOptions solver_options(const Problem& problem, const PlanOptions& options) {
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

/// Start number `index`: the problem's own guess first, then smooth random ones.
Start make_start(Programme& programme, const std::optional<EarlierPlan>& earlier, int index, std::uint64_t seed) {
  GuessSpec spec = programme.problem().guess;
  if (index > 0) spec.kind = "random";
  if (index == 0 && earlier && earlier->fits(programme)) return {earlier->x, earlier->duals};
  return {initial_guess(programme, spec, seed, earlier ? &earlier->trajectory : nullptr)};
}

NlpResult solve_starts(Plan& plan, const std::optional<EarlierPlan>& earlier, const PlanOptions& options) {
  Programme& programme = *plan.programme;
  const SolverSpec& spec = programme.problem().solver;
  const auto seed = static_cast<std::uint64_t>(spec.seed);
  const SolverOptions solver = solver_options(programme.problem(), options);
  if (spec.starts <= 1) {
    return solve_nlp(programme, make_start(programme, earlier, 0, task_seed(seed, 0)), solver);
  }
  MultiStartOptions multi;
  multi.seed = seed;
  multi.tasks.workers = options.jobs;
  MultiStart all = multi_start(
      spec.starts,
      [&](int index, std::uint64_t own) {
        return solve_nlp(programme, make_start(programme, earlier, index, own), solver);
      },
      multi);
  const int taken = all.best >= 0 ? all.best : all.least_bad;
  plan.starts = {spec.starts, all.converged, static_cast<int>(std::lround(all.near_share * spec.starts)),
                 std::max(taken, 0)};
  if (taken >= 0) return std::move(all.starts[static_cast<std::size_t>(taken)].result);
  NlpResult none;
  none.status = interrupt_requested() ? Status::interrupted : Status::failed;
  none.message = interrupt_requested() ? "interrupted before any start ended" : "no start ran to its end";
  for (const StartOutcome& start : all.starts) {
    if (!start.error.empty()) none.message += ": " + start.error;
    if (!start.error.empty()) break;
  }
  return none;
}

/// Halves every interval whose error is above the tolerance; false where none is.
bool refine(Problem& problem, const Layout& layout, const Vector& errors) {
  bool any = false;
  for (std::size_t p = 0; p < problem.phases.size(); ++p) {
    const PhaseBlock& block = layout.phases[p];
    std::vector<double> mesh;
    for (int k = block.first_interval; k <= block.last_interval; ++k) {
      const double fraction = layout.intervals[static_cast<std::size_t>(k)].fraction;
      const bool split = errors[k] > problem.refinement.tolerance;
      mesh.insert(mesh.end(), split ? 2 : 1, split ? 0.5 * fraction : fraction);
      any = any || split;
    }
    problem.phases[p].intervals = static_cast<int>(mesh.size());
    problem.phases[p].mesh = mesh;
  }
  return any;
}

/// Solves again on finer meshes, each time from the plan before, as long as that converges.
void refine_mesh(Plan& plan, Problem problem, const PlanarModel& model, const PlanOptions& options) {
  while (plan.converged() && plan.refinements < problem.refinement.max_rounds) {
    const Vector errors = interval_errors(*plan.programme, plan.result.x());
    if (!refine(problem, plan.programme->layout(), errors)) return;
    const Trajectory before = to_trajectory(*plan.programme, plan.result.x());
    auto finer = std::make_unique<Programme>(problem, model);
    GuessSpec spec = problem.guess;
    spec.kind = "file";
    const Start start{initial_guess(*finer, spec, 0, &before)};
    SolverOptions near = solver_options(problem, options);
    near.ipopt = {{"mu_init", "1e-4"},  // the start is nearly optimal: stay close to it and to its active bounds
                  {"bound_push", "1e-8"},
                  {"bound_frac", "1e-8"},
                  {"slack_bound_push", "1e-8"},
                  {"slack_bound_frac", "1e-8"}};
    NlpResult result = solve_nlp(*finer, start, near);
    if (!result.converged()) return;  // the coarser plan stands, its verification tells how good it is
    result.iterations += plan.result.iterations;
    plan.result = std::move(result);
    plan.programme = std::move(finer);
    ++plan.refinements;
  }
}

void diagnose(Plan& plan) {
  Programme& programme = *plan.programme;
  const Vector x = plan.result.last_iterate();
  if (x.size() != programme.variables()) return;
  if (auto ranked = ranked_violations(programme, x, kMostViolations)) plan.violations = std::move(*ranked);
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
  plan.result = solve_starts(plan, earlier, options);
  refine_mesh(plan, problem, planned, options);
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
