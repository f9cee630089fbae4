// The solver of the library behind `solve` and `compare`: a plan and its figures.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "cli/plan.h"
#include "cli/reporting.h"
#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/solver/plan.h"

namespace jaculus::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kAtBound = 1e-4;  // of the width of a duration's bounds
constexpr std::size_t kMostAgainst = 8;

std::vector<PhaseFigures> phase_figures(const Plan& plan) {
  std::vector<PhaseFigures> phases;
  const Layout& layout = plan.programme->layout();
  const Vector& x = plan.result.last_iterate();
  for (const PhaseBlock& phase : layout.phases) {
    const int c = phase.duration;
    const double slack = kAtBound * (layout.upper[c] - layout.lower[c]);
    const bool fixed = layout.lower[c] == layout.upper[c];
    const bool at_bound = !fixed && (x[c] - layout.lower[c] < slack || layout.upper[c] - x[c] < slack);
    phases.push_back({phase.name, x[c], at_bound});
  }
  return phases;
}

/// Forward velocities at the plan's end over its duration, of base and centre of mass.
void fill_velocities(const Plan& plan, Summary& s) {
  const Equations& equations = plan.programme->equations();
  const Trajectory& t = *plan.trajectory;
  const PlanarModel& model = equations.model();
  s.duration = t.time[t.samples() - 1] - t.time[0];
  const int x = model.coordinate_index("x");
  if (x < 0) return;  // a base that can't move forward has no leap to speak of
  s.liftoff_velocity = t.velocity(x, t.samples() - 1);
  s.average_acceleration = s.liftoff_velocity / s.duration;
  Motion motion(equations.tree());
  const Vector q = t.position.col(t.samples() - 1), v = t.velocity.col(t.samples() - 1);
  if (!set_configuration(equations.tree(), q, motion)) return;
  set_rates(equations.tree(), v, motion);
  s.liftoff_velocity_com = linear_momentum(equations.tree(), motion).x() / model.total_mass();
  s.average_acceleration_com = s.liftoff_velocity_com / s.duration;
}

void fill_peaks(const Plan& plan, Summary& s) {
  const Trajectory& t = *plan.trajectory;
  const auto peak = [](const Matrix& values, std::size_t m) {
    return values.row(static_cast<Eigen::Index>(m)).cwiseAbs().maxCoeff();
  };
  for (std::size_t m = 0; m < s.motors.size(); ++m) {
    MotorFigures& f = s.motors[m];
    f.joint_torque = peak(t.torque, m);
    f.motor_torque = peak(t.motor_torque, m);
    f.current = peak(t.current, m);
    f.voltage = peak(t.voltage, m);
  }
}

void fill_verification(const Plan& plan, Summary& s) {
  if (!plan.verification) {
    s.verification.failures.emplace_back("the equations are not defined where the solver ended; nothing was verified");
    return;
  }
  const PlanVerification& from = *plan.verification;
  Verification& to = s.verification;
  to.passed = from.passed;
  to.failures = from.failures;
  for (const CoordinateError& error : from.errors) {
    to.reintegration_error[error.coordinate] = error.position;
    to.reintegration_velocity_error[error.coordinate] = error.velocity;
  }
  to.worst_violation = {from.worst_row, from.worst_row_amount, from.worst_row_unit};
  if (!from.limits.empty()) {
    const LimitExcess& worst = from.limits.front();
    to.off_node_violation = {fmt::format("{}, {} at {:.4f} s", worst.name, worst.phase, worst.time), worst.amount,
                             worst.unit};
  }
  to.momentum_balance = from.momentum_balance;
  to.energy_balance = from.energy_balance;
  s.tail_momentum_share = from.drag_momentum_share;
  for (const std::string& remark : from.remarks) s.warnings.push_back(remark);
}

void fill_limits(const Plan& plan, Summary& s) {
  for (const PlanLimit& limit : plan.limits)
    s.active_limits.push_back({limit.name, limit.phase, limit.from, limit.to, limit.nodes});
  const std::string unit = plan.objective_unit.empty() ? "of the objective" : plan.objective_unit;
  for (const PlanPrice& price : plan.prices)
    s.prices.push_back({price.limit, price.gain, fmt::format("{} per {}", unit, price.unit)});
}

void fill_failure(const Plan& plan, Summary& s) {
  for (const Violation& v : plan.violations) s.violated_rows.push_back({v.name, v.amount, v.unit});
  if (!plan.conflict) return;
  if (plan.conflict->feasible) {
    s.warnings.emplace_back(
        "all constraints can hold together: it is the search that failed; try another guess or more starts");
  }
  for (const Relaxation& r : plan.conflict->relaxed) s.conflict.push_back({r.name, r.amount, r.unit});
  for (const LimitPrice& price : plan.conflict->against) {
    if (s.conflict_against.size() == kMostAgainst) break;
    s.conflict_against.push_back(
        fmt::format("{} ({}, {:.4g} {})", price.name, to_string(price.side), price.limit, price.unit));
  }
}

void add_warnings(const Plan& plan, Summary& s) {
  for (const PhaseFigures& phase : s.phases) {
    if (phase.at_bound) s.warnings.push_back(fmt::format("the duration of {} stands at its bound", phase.name));
  }
  if (plan.starts.count > 1) {
    const auto percent = [&](int part) { return 100.0 * part / plan.starts.count; };
    s.warnings.push_back(
        fmt::format("{} of {} starts converged ({:.0f} %), {} within 0.5 % of the best ({:.0f} %); start {} was taken; "
                    "every random "
                    "start went through a feasibility stage first",
                    plan.starts.converged, plan.starts.count, percent(plan.starts.converged), plan.starts.near_best,
                    percent(plan.starts.near_best), plan.starts.best));
  }
  if (plan.result.feasibility_iterations > 0) {
    s.warnings.push_back(
        fmt::format("{} of the iterations went into a point that satisfies the constraints to start from",
                    plan.result.feasibility_iterations));
  }
  for (std::size_t k = 1; k < plan.mesh_rounds.size(); ++k) {
    const MeshRound &before = plan.mesh_rounds[k - 1], &round = plan.mesh_rounds[k];
    s.warnings.push_back(fmt::format("mesh refined to {} intervals: the objective went from {:.6g} to {:.6g}",
                                     fmt::join(round.intervals, " + "), before.objective, round.objective));
  }
  for (const std::string& note : plan.notes) s.warnings.push_back(note);
  if (!plan.refinement_failure.empty()) s.warnings.push_back(plan.refinement_failure);
}

Summary summarise(const Plan& plan, const Problem& problem) {
  const Programme& programme = *plan.programme;
  const NlpResult& result = plan.result;
  Summary s;
  s.name = problem.name;
  s.caption = problem.caption;
  s.status = to_string(result.status);
  s.converged = result.converged();
  s.message = result.message;
  s.objective = problem.maximise ? -result.objective : result.objective;
  s.iterations = result.iterations;
  s.size = {programme.variables(), programme.rows(), programme.jacobian_sparsity().size(),
            programme.hessian_sparsity().size()};
  s.input_hold = problem.transcription.inputs == InputHold::held ? "held" : "linear";
  s.seed = problem.solver.seed;
  s.reference = problem.reference;
  s.problem = describe_problem(problem);
  s.motors = motor_figures(programme.equations().model());
  for (MotorFigures& f : s.motors) {
    if (problem.torque) f.torque_limit = *problem.torque;
    if (problem.current) f.current_limit = *problem.current;
    if (problem.voltage) f.voltage_limit = *problem.voltage;
  }
  if (plan.trajectory) {
    s.phases = phase_figures(plan);
    fill_velocities(plan, s);
    fill_peaks(plan, s);
  }
  fill_verification(plan, s);
  fill_limits(plan, s);
  fill_failure(plan, s);
  add_warnings(plan, s);
  return s;
}

Json timing_json(const NlpResult& result) {
  return {{"wall_seconds",
           {{"total", result.wall_seconds.total},
            {"functions", result.wall_seconds.functions},
            {"linear_solver", result.wall_seconds.linear_solver}}},
          {"iterations", result.iterations}};
}

}  // namespace

SolvedProblem solve_loaded(const Loaded& loaded, const Common& common, const Progress& progress) {
  PlanOptions options;
  options.jobs = common.jobs;
  options.progress = progress;
  options.starts_progress = progress_bar(common, loaded.problem.name + ", starts");
  const Plan plan = make_plan(loaded.problem, loaded.robot.planar, options);
  SolvedProblem solved;
  solved.summary = summarise(plan, loaded.problem);
  solved.trajectory = plan.trajectory;
  solved.solution = solution_json(plan);
  solved.history = plan.result.history;
  solved.timing = timing_json(plan.result);
  return solved;
}

}  // namespace jaculus::cli
