#include "jaculus/solver/summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/transcription/describe.h"
#include "solver/failure.h"

namespace jaculus::solver {
namespace {

constexpr double kAtBound = 1e-4;  // of the width of a duration's bounds
constexpr std::size_t kMostAgainst = 8;

std::vector<PhaseFigures> phase_figures(const Plan& plan) {
  std::vector<PhaseFigures> phases;
  const transcription::Layout& layout = plan.program->layout();
  const Vector& x = plan.result.last_iterate();
  for (const transcription::PhaseBlock& phase : layout.phases) {
    const int c = phase.duration;
    const double slack = kAtBound * (layout.upper[c] - layout.lower[c]);
    const bool fixed = layout.lower[c] == layout.upper[c];
    const bool at_bound =
        !fixed && (x[c] - layout.lower[c] < slack || layout.upper[c] - x[c] < slack);
    phases.push_back({phase.name, x[c], at_bound});
  }
  return phases;
}

/// Forward velocities at the plan's end over its duration, of base and centre of mass.
void fill_velocities(const Plan& plan, Summary& s) {
  const components::Equations& equations = plan.program->equations();
  const trajectory::Trajectory& t = *plan.trajectory;
  const model::PlanarModel& model = equations.model();
  s.duration = t.time[t.samples() - 1] - t.time[0];
  const int x = model.coordinate_index("x");
  if (x < 0) return;  // a base that can't move forward has no leap to speak of
  s.liftoff_velocity = t.velocity(x, t.samples() - 1);
  s.average_acceleration = s.liftoff_velocity / s.duration;
  dynamics::Motion motion(equations.tree());
  const Vector q = t.position.col(t.samples() - 1), v = t.velocity.col(t.samples() - 1);
  if (!dynamics::set_configuration(equations.tree(), q, motion)) return;
  dynamics::set_rates(equations.tree(), v, motion);
  const Vec2 of_mass = dynamics::linear_momentum(equations.tree(), motion) / model.total_mass();
  s.liftoff_velocity_com = of_mass.x();
  s.liftoff_rise_com = of_mass.y();
  s.average_acceleration_com = s.liftoff_velocity_com / s.duration;
}

void fill_peaks(const Plan& plan, Summary& s) {
  const trajectory::Trajectory& t = *plan.trajectory;
  const auto peak = [](const Matrix& values, std::size_t m) {
    return values.row(m).cwiseAbs().maxCoeff();
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
    s.verification.failures.emplace_back(
        "the equations are not defined where the solver ended; nothing was verified");
    return;
  }

  const PlanVerification& from = *plan.verification;
  VerificationFigures& to = s.verification;
  to.passed = from.passed;
  to.failures = from.failures;
  for (const CoordinateError& error : from.errors) {
    to.reintegration_error[error.coordinate] = error.position;
    to.reintegration_velocity_error[error.coordinate] = error.velocity;
  }

  to.worst_violation = {from.worst_row, from.worst_row_amount, from.worst_row_unit};
  if (!from.limits.empty()) {
    const LimitExcess& worst = from.limits.front();
    to.off_node_violation = {fmt::format("{}, {} at {:.4f} s", worst.name, worst.phase, worst.time),
                             worst.amount, worst.unit};
  }
  to.momentum_balance = from.momentum_balance;
  to.energy_balance = from.energy_balance;
  s.tail_momentum_share = from.drag_momentum_share;
  for (const std::string& remark : from.remarks) s.warnings.push_back(remark);
}

void fill_limits(const Plan& plan, Summary& s) {
  s.active_limits = plan.limits;
  const std::string unit = plan.objective_unit.empty() ? "of the objective" : plan.objective_unit;
  for (const PlanSensitivity& limit : plan.sensitivities)
    s.gains.push_back({limit.limit, limit.gain, fmt::format("{} per {}", unit, limit.unit)});
}

void fill_failure(const Plan& plan, Summary& s) {
  for (const Violation& v : plan.violations) s.violated_rows.push_back({v.name, v.amount, v.unit});
  if (!plan.conflict) return;
  if (plan.conflict->feasible) {
    s.warnings.emplace_back(
        "all constraints can hold together: it is the search that failed; try another guess or "
        "more starts");
  }
  s.binds = binding_sentence(*plan.conflict, plan.program->equations().model());
  for (const Relaxation& r : plan.conflict->relaxed)
    s.conflict.push_back({r.name, r.amount, r.unit});
  for (const LimitSensitivity& limit : plan.conflict->against) {
    if (s.conflict_against.size() == kMostAgainst) break;
    s.conflict_against.push_back(fmt::format("{} ({}, {:.4g} {})", limit.name,
                                             to_string(limit.side), limit.limit, limit.unit));
  }
}

/// Bounds of the base at the plan's end that v/T is held at: such an end is the least or most that
/// the problem allows, and seldom what one would want.
void add_ends_at_bounds(const Plan& plan, Summary& s) {
  if (std::isnan(s.average_acceleration) || !plan.converged()) return;
  const transcription::Layout& layout = plan.program->layout();
  const Vector& x = plan.result.last_iterate();
  const transcription::NodeBlock& last = layout.nodes.back();
  const std::vector<model::Coordinate>& coordinates = plan.program->equations().model().coordinates;

  const auto add = [&](int column, const std::string& what) {
    const double lower = layout.lower[column], upper = layout.upper[column];
    if (lower == upper) return;  // imposed
    const double slack = kAtBound * layout.scale[column];
    const bool least = x[column] - lower < slack;
    if (!least && upper - x[column] >= slack) return;
    s.warnings.push_back(fmt::format(
        "v/T stands at a bound: at the plan's end the {} is the {} that the problem allows, "
        "{:.4g} {}",
        what, least ? "least" : "largest", x[column], layout.units[column]));
  };
  for (int i = 0; i < layout.n; ++i) {
    const std::string& name = coordinates[i].name;
    if (name != "x" && name != "z" && name != "pitch") continue;
    add(last.q + i, name == "z" ? "height z of the base" : "base's " + name);
    add(last.v + i, "velocity of the base's " + name);
  }
}

/// A leap for v/T whose centre of mass falls at its end, or rises for less than an interval of the
/// last phase's mesh, falls over its feet: it has no flight.
void add_missing_flight(const Plan& plan, Summary& s) {
  const double gravity = plan.program->equations().model().gravity;
  if (std::isnan(s.liftoff_rise_com) || !plan.converged() || s.phases.empty()) return;
  const double flight = 2.0 * s.liftoff_rise_com / gravity;
  const transcription::PhaseBlock& last = plan.program->layout().phases.back();
  const double interval = s.phases.back().duration / (last.last_interval - last.first_interval + 1);
  if (!(gravity > 0.0) || flight >= interval) return;
  s.warnings.push_back(fmt::format(
      "no flight follows: at the plan's end the centre of mass {} at {:.3g} m/s, so that the robot "
      "falls over its feet and does not leap; ask for a rise (a least velocity of z at the end)",
      s.liftoff_rise_com > 0.0 ? "rises" : "falls", std::abs(s.liftoff_rise_com)));
}

void add_warnings(const Plan& plan, Summary& s) {
  for (const PhaseFigures& phase : s.phases) {
    if (phase.at_bound)
      s.warnings.push_back(fmt::format("the duration of {} stands at its bound{}", phase.name,
                                       plan.starts.count > 1
                                           ? ""
                                           : "; more starts (--starts 10) tell whether another "
                                             "optimum is better"));
  }
  add_ends_at_bounds(plan, s);
  add_missing_flight(plan, s);
  if (plan.starts.ended < plan.starts.count)
    s.warnings.push_back(fmt::format(
        "interrupted: {} of {} starts had ended{}", plan.starts.ended, plan.starts.count,
        plan.converged() ? ", and the plan is the best of those; a better one may be "
                           "among the others"
                         : ", none with a plan that holds"));
  if (plan.starts.count > 1 && plan.starts.ended > 0) {
    const auto percent = [&](int part) { return 100.0 * part / std::max(1, plan.starts.ended); };
    s.warnings.push_back(
        fmt::format("{} of {} starts converged ({:.0f} %), {} within 0.5 % of the best ({:.0f} %); "
                    "start {} was taken; "
                    "every random "
                    "start went through a feasibility stage first",
                    plan.starts.converged, plan.starts.ended, percent(plan.starts.converged),
                    plan.starts.near_best, percent(plan.starts.near_best), plan.starts.best));
    if (!plan.starts.passed_over.empty())
      s.warnings.push_back(
          fmt::format("start {} found better, but its plan does not hold between "
                      "nodes and was not taken",
                      fmt::join(plan.starts.passed_over, ", ")));
  }

  if (plan.result.feasibility_iterations > 0) {
    s.warnings.push_back(fmt::format(
        "{} of the iterations went into a point that satisfies the constraints to start from",
        plan.result.feasibility_iterations));
  }

  for (std::size_t k = 1; k < plan.mesh_rounds.size(); ++k) {
    const MeshRound &before = plan.mesh_rounds[k - 1], &round = plan.mesh_rounds[k];
    s.warnings.push_back(
        fmt::format("mesh refined to {} intervals: the objective went from {:.6g} to {:.6g}",
                    fmt::join(round.intervals, " + "), before.objective, round.objective));
  }
  for (const std::string& note : plan.notes) s.warnings.push_back(note);
  if (!plan.refinement_failure.empty()) s.warnings.push_back(plan.refinement_failure);
}

}  // namespace

std::vector<MotorFigures> motor_figures(const model::PlanarModel& model) {
  std::vector<MotorFigures> figures;
  for (const model::PlanarMotor& m : model.motors) {
    MotorFigures f;
    f.joint = m.joint;
    f.count = m.count;
    f.file_joints = model.bodies[m.body].file_joints;
    f.slides = model.slides(m);
    f.torque_limit = m.torque_limit;
    f.current_limit = m.current_limit;
    f.voltage_limit = m.voltage;
    f.speed_limit = m.speed_limit;
    f.gear = m.gear;
    f.efficiency = m.efficiency;
    f.torque_constant = m.torque_constant;
    f.resistance = m.resistance;
    f.saturation_linear = m.saturation_linear;
    f.saturation_cubic = m.saturation_cubic;
    f.dry_friction = m.dry_friction;
    figures.push_back(f);
  }

  return figures;
}

Summary summarise(const Plan& plan, const transcription::Problem& problem) {
  const transcription::NonlinearProgram& program = *plan.program;
  const NlpResult& result = plan.result;
  Summary s;
  s.name = problem.name;
  s.caption = problem.caption;
  s.status = result.status;
  s.message = result.message;
  s.objective = problem.maximise ? -result.objective : result.objective;
  s.iterations = result.iterations;
  s.size = {program.variables(), program.rows(), program.jacobian_sparsity().size(),
            program.hessian_sparsity().size()};
  s.input_hold = problem.transcription.inputs;
  s.seed = problem.solver.seed;
  s.reference = problem.reference;
  s.problem = transcription::describe_problem(problem);
  if (!model::is_installed(problem.robot)) s.robot_folder = problem.robot_folder.generic_string();
  model::PlanarModel limited = program.equations().model();
  for (model::PlanarMotor& motor : limited.motors)
    motor = transcription::limited_motor(problem, limited, motor);
  s.motors = motor_figures(limited);
  s.held_joints = program.equations().model().held;

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

double published(const Summary& summary, const std::string& figure) {
  const auto found = summary.reference.find(figure);
  return found == summary.reference.end() ? kNaN : found->second;
}

double largest(const std::vector<MotorFigures>& motors, double MotorFigures::*figure) {
  double largest = kNaN;
  for (const MotorFigures& m : motors) largest = std::fmax(largest, m.*figure);
  return largest;
}

}  // namespace jaculus::solver
