#include "jaculus/solver/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "jaculus/core/angle.h"
#include "jaculus/solver/violations.h"
#include "solver/verify_limits.h"
#include "solver/verify_motion.h"

namespace jaculus::solver {

namespace {

using detail::IntervalInput;
using detail::LimitMonitor;
using detail::Motion78;
using detail::Totals;
using detail::totals;

IntervalInput interval_input(const transcription::Layout& layout, const ConstVectorRef& x, int k) {
  const transcription::IntervalBlock& block = layout.intervals[k];
  const transcription::PhaseBlock& phase = layout.phases[block.phase];
  return {x.segment(block.u_first, layout.n_u), x.segment(block.u_last, layout.n_u),
          block.fraction * x[phase.duration]};
}

/// Compares the motion with the nodes as it passes them.
struct NodeErrors {
  const transcription::NonlinearProgram& program;
  const ConstVectorRef& x;
  PlanVerification& result;
  double worst = 0.0;

  void start() {
    for (const model::Coordinate& c : program.equations().model().coordinates)
      result.errors.push_back({c.name, c.angular, 0.0, 0.0, "", ""});
  }

  void compare(int node, int phase, int number, const Motion78& motion) {
    const transcription::Layout& layout = program.layout();
    const transcription::NodeBlock& block = layout.nodes[node];
    const std::string name = fmt::format("{}, node {}", layout.phases[phase].name, number);
    for (int i = 0; i < layout.n; ++i) {
      CoordinateError& e = result.errors[i];
      const double position = std::abs(motion.q()[i] - x[block.q + i]);
      const double velocity = std::abs(motion.v()[i] - x[block.v + i]);
      if (position > e.position) e.position = position, e.position_node = name;
      if (velocity > e.velocity) e.velocity = velocity, e.velocity_node = name;
      const double scaled =
          std::max(position / layout.scale[block.q + i], velocity / layout.scale[block.v + i]);
      if (scaled > worst) worst = scaled, result.worst_node = name;
    }
  }

  void aggregate() const {
    result.length_error = result.angle_error = result.velocity_error = result.rate_error = 0.0;
    for (const CoordinateError& e : result.errors) {
      double& position = e.angular ? result.angle_error : result.length_error;
      double& velocity = e.angular ? result.rate_error : result.velocity_error;
      position = std::max(position, e.position);
      velocity = std::max(velocity, e.velocity);
    }
  }
};

/// Integrates one interval, looking at every sample. False where it can't be integrated.
bool pass_interval(int k, double start, const IntervalInput& input, int samples, Motion78& motion,
                   LimitMonitor& monitor) {
  for (int j = 0; j <= samples; ++j) {
    const double s = static_cast<double>(j) / samples, t = s * input.length;
    if (j > 0 && !motion.advance(input, static_cast<double>(j - 1) / samples * input.length, t))
      return false;
    const Vector u = input.at(t);
    if (!motion.observe(u)) return false;
    monitor.check_point(k, s, start + t, u, motion.point());
  }
  return true;
}

bool pass_phase(const transcription::NonlinearProgram& program, const ConstVectorRef& x, int p,
                double start, int samples, Motion78& motion, LimitMonitor& monitor,
                NodeErrors& errors) {
  const transcription::Layout& layout = program.layout();
  const transcription::PhaseBlock& phase = layout.phases[p];
  motion.begin_phase(phase.feet);
  if (!phase.landing.empty() && !motion.land()) return false;
  errors.compare(phase.first_node, p, 0, motion);
  for (int k = phase.first_interval; k <= phase.last_interval; ++k) {
    const IntervalInput input = interval_input(layout, x, k);
    if (!(input.length > 0.0) || !motion.observe(input.first)) return false;
    if (k == phase.first_interval) monitor.begin_phase(motion.point());
    if (!pass_interval(k, start, input, samples, motion, monitor)) return false;
    start += input.length;
    const transcription::IntervalBlock& block = layout.intervals[k];
    errors.compare(block.last, p, block.number + 1, motion);
  }
  return true;
}

double relative(double difference, std::initializer_list<double> terms) {
  double scale = 0.0;
  for (double term : terms) scale = std::max(scale, std::abs(term));
  return scale > 0.0 ? std::abs(difference) / scale : std::abs(difference);
}

/// Largest change of energy between the first node and any other [J]: what a balance from rest to
/// rest is relative to.
double energy_swing(const transcription::NonlinearProgram& program, const ConstVectorRef& x,
                    double start) {
  const transcription::Layout& layout = program.layout();
  double swing = 0.0;
  for (const transcription::NodeBlock& node : layout.nodes) {
    const auto at =
        totals(program.equations(), x.segment(node.q, layout.n), x.segment(node.v, layout.n));
    if (at) swing = std::max(swing, std::abs(at->energy - start));
  }
  return swing;
}

void balance(const transcription::NonlinearProgram& program, const Totals& first,
             const Totals& plan_end, const Totals& motion_end, double swing, double duration,
             const detail::Ledger& ledger, PlanVerification& r) {
  const model::PlanarModel& model = program.equations().model();
  r.momentum_change = motion_end.momentum - first.momentum;
  r.gravity_impulse = Vec2(0.0, -model.total_mass() * model.gravity * duration);
  r.feet_impulse = ledger.feet;
  r.drag_impulse = ledger.drag;

  if (model.base_free[0] || model.base_free[1]) {
    // A direction that the base can't move along has reactions of its bearing, which nobody knows.
    const Vec2 free(model.base_free[0] ? 1.0 : 0.0, model.base_free[1] ? 1.0 : 0.0);
    const Vec2 impulse = free.cwiseProduct(r.gravity_impulse + r.feet_impulse + r.drag_impulse);
    const auto miss = [&](const Totals& end) {
      const Vec2 change = end.momentum - first.momentum;
      return relative(
          (change - impulse).norm(),
          {change.norm(), free.cwiseProduct(r.gravity_impulse).norm(),
           free.cwiseProduct(r.feet_impulse).norm(), free.cwiseProduct(r.drag_impulse).norm()});
    };
    r.momentum_balance = miss(plan_end);
    r.motion_momentum_balance = miss(motion_end);
  }

  r.energy_change = motion_end.energy - first.energy;
  r.motor_work = ledger.motor_work;
  r.drag_work = ledger.drag_work;
  r.impact_work = ledger.impact_work;

  const auto miss = [&](const Totals& end) {
    const double change = end.energy - first.energy;
    return relative(
        change - r.motor_work - r.drag_work - r.impact_work,
        {change, swing, r.motor_work, r.drag_work, r.impact_work, first.energy, end.energy});
  };
  r.energy_balance = miss(plan_end);
  r.motion_energy_balance = miss(motion_end);

  if (!model.drags.empty() && model.base_free[0] && r.momentum_change.x() != 0.0)
    r.drag_momentum_share = r.drag_impulse.x() / r.momentum_change.x();
}

bool integrate(const transcription::NonlinearProgram& program, const ConstVectorRef& x,
               const VerifyOptions& options, PlanVerification& r) {
  const transcription::Layout& layout = program.layout();
  const transcription::NodeBlock &first = layout.nodes.front(), &last = layout.nodes.back();
  const auto state = [&](const transcription::NodeBlock& node, bool rate) {
    return x.segment(rate ? node.v : node.q, layout.n);
  };

  Motion78 motion(program.equations(), options.integration);
  motion.place(state(first, false), state(first, true));
  LimitMonitor monitor(program);
  NodeErrors errors{program, x, r};
  errors.start();

  double time = 0.0;
  bool whole = true;
  for (int p = 0; whole && p < count_of(layout.phases); ++p) {
    whole = pass_phase(program, x, p, time, options.samples, motion, monitor, errors);
    time += x[layout.phases[p].duration];
  }

  r.steps = motion.steps();
  r.limits = monitor.excesses();
  r.interval_excess = monitor.by_interval();
  if (!whole) return false;
  errors.aggregate();

  const auto at_first = totals(program.equations(), state(first, false), state(first, true));
  const auto at_last = totals(program.equations(), state(last, false), state(last, true));
  const auto at_end = totals(program.equations(), motion.q(), motion.v());
  if (!at_first || !at_last || !at_end) return false;

  const double swing = energy_swing(program, x, at_first->energy);
  balance(program, *at_first, *at_last, *at_end, swing, time, motion.ledger(), r);
  return true;
}

/// Written so that a value that is no number fails.
void fail_over(PlanVerification& r, const std::string& what, double value, double tolerance,
               double factor, const std::string& unit) {
  if (value <= tolerance) return;
  r.failures.push_back(fmt::format("{} by {:.3g}{}; allowed: {:.3g}{}", what, factor * value, unit,
                                   factor * tolerance, unit));
}

/// Limits passed between nodes: little is what a coarse grid leaves and is said, much is another
/// plan and fails.
void judge_limits(const VerifyOptions& options, PlanVerification& r) {
  for (const LimitExcess& e : r.limits) {
    const bool failed = e.of_foot ? !(e.amount <= options.slip) : !(e.scaled <= options.between);
    if (!failed && e.scaled < options.remark) continue;
    const std::string text =
        fmt::format("between nodes {} reaches {:.4g} {} at {:.4f} s ({}); its limit is {:.4g}",
                    e.name, e.value, e.unit, e.time, e.phase, e.limit);
    (failed ? r.failures : r.remarks).push_back(text);
  }
}

/// `moves`: the base can move along x or z, so that its momentum has a balance.
void judge(const VerifyOptions& options, bool moves, PlanVerification& r) {
  if (!r.integrated) {
    r.failures.push_back(
        "the inputs cannot be integrated from the first node to the end of the plan");
  } else {
    const std::string where =
        fmt::format("re-integration misses the nodes (worst: {})", r.worst_node);
    fail_over(r, where + " in position", r.length_error, options.length, 1e3, " mm");
    fail_over(r, where + " in angle", r.angle_error, options.angle, kDegrees, " deg");
    fail_over(r, where + " in velocity", r.velocity_error, options.velocity, 1.0, " m/s");
    fail_over(r, where + " in rate", r.rate_error, options.rate, 1.0, " rad/s");

    if (moves) {
      fail_over(r, "the plan's momentum misses its impulses", r.momentum_balance, options.balance,
                1.0, " of the largest");
      fail_over(r, "momentum of the equations does not balance", r.motion_momentum_balance,
                options.balance, 1.0, "");
    }
    fail_over(r, "the plan's energy misses its work", r.energy_balance, options.balance, 1.0,
              " of the largest");
    fail_over(r, "energy of the equations does not balance", r.motion_energy_balance,
              options.balance, 1.0, "");
  }

  if (!(r.worst_row_scaled <= options.row)) {
    r.failures.push_back(fmt::format("{} is violated by {:.3g} {}", r.worst_row, r.worst_row_amount,
                                     r.worst_row_unit));
  }

  judge_limits(options, r);
  r.passed = r.failures.empty();
}

}  // namespace

PlanVerification verify_plan(transcription::NonlinearProgram& program, const ConstVectorRef& x,
                             const VerifyOptions& options) {
  assert(x.size() == program.variables() && options.samples > 0);
  PlanVerification r;

  if (!x.allFinite()) {
    r.failures.push_back("the plan holds values that are no numbers");
    return r;
  }

  r.integrated = integrate(program, x, options, r);

  const auto rows = ranked_violations(program, x, 1);
  if (!rows) {
    r.failures.push_back("the constraints are not defined at the plan's nodes");
  } else if (!rows->empty()) {
    const Violation& worst = rows->front();
    r.worst_row = worst.name;
    r.worst_row_unit = worst.unit;
    r.worst_row_amount = worst.amount;
    r.worst_row_scaled = worst.scaled;
  }

  const model::PlanarModel& model = program.equations().model();
  judge(options, model.base_free[0] || model.base_free[1], r);
  return r;
}

Vector interval_errors(transcription::NonlinearProgram& program, const ConstVectorRef& x,
                       const VerifyOptions& options) {
  assert(x.size() == program.variables());
  const transcription::Layout& layout = program.layout();
  Vector errors(count_of(layout.intervals));
  Motion78 motion(program.equations(), options.integration);

  for (int k = 0; k < errors.size(); ++k) {
    const transcription::IntervalBlock& block = layout.intervals[k];
    const transcription::NodeBlock &first = layout.nodes[block.first],
                                   &last = layout.nodes[block.last];
    const int n = layout.n;

    motion.place(x.segment(first.q, n), x.segment(first.v, n));
    motion.begin_phase(layout.phases[block.phase].feet);
    const IntervalInput input = interval_input(layout, x, k);

    errors[k] = kInfinity;
    if (!(input.length > 0.0) || !motion.advance(input, 0.0, input.length)) continue;

    const Vector q =
        (motion.q() - x.segment(last.q, n)).cwiseQuotient(layout.scale.segment(last.q, n));
    const Vector v =
        (motion.v() - x.segment(last.v, n)).cwiseQuotient(layout.scale.segment(last.v, n));
    errors[k] = std::max(q.cwiseAbs().maxCoeff(), v.cwiseAbs().maxCoeff());
  }
  return errors;
}

}  // namespace jaculus::solver
