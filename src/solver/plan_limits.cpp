// Which limits are active when, and what they cost. Formulas at the top of plan.h.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/components/motor.h"
#include "jaculus/solver/plan.h"

namespace jaculus::solver {
namespace {

constexpr double kActive = 1e-4;      // of the scale: nearer to a limit than this counts as active
constexpr double kNegligible = 1e-6;  // smallest gain that is shown

bool active(double value, double lower, double upper, double scale) {
  if (lower == upper) return false;  // an equality holds always and holds nothing back
  return value - lower < kActive * scale || upper - value < kActive * scale;
}

/// Active limits of one phase, in the order in which they turn up.
class LimitList {
 public:
  void add(const std::string& name, const std::string& phase, double from, double to) {
    for (PlanLimit& limit : list_) {
      if (limit.name != name || limit.phase != phase) continue;
      limit.from = std::min(limit.from, from);
      limit.to = std::max(limit.to, to);
      ++limit.nodes;
      return;
    }
    list_.push_back({name, phase, from, to, 1});
  }
  std::vector<PlanLimit> take() { return std::move(list_); }

 private:
  std::vector<PlanLimit> list_;
};

std::vector<double> interval_starts(const transcription::NonlinearProgram& program) {
  std::vector<double> starts;
  double time = 0.0;
  for (const transcription::Interval& interval : program.intervals()) {
    starts.push_back(time);
    time += interval.length();
  }
  return starts;
}

/// Unit and weight of the objective where all its terms of the wanted direction are of one type.
void name_objective(Plan& plan) {
  const transcription::TermSpec* main = nullptr;
  for (const transcription::TermSpec& term : plan.program->problem().objective) {
    if (term.weight <= 0.0) continue;  // the lesser part, in the other direction
    if (main != nullptr) return;
    main = &term;
  }
  if (main == nullptr || main->declared->unit.empty()) return;
  plan.objective_unit = main->declared->unit;
  plan.objective_weight = main->weight;
}

/// Improvement of the objective by limit, summed over rows, in order of first appearance.
class SensitivitySums {
 public:
  void add(const std::string& limit, const std::string& unit, double gain) {
    for (PlanSensitivity& item : list_) {
      if (item.limit != limit) continue;
      item.gain += gain;
      return;
    }
    list_.push_back({limit, unit, gain});
  }
  std::vector<PlanSensitivity> take(double weight) {
    for (PlanSensitivity& item : list_) item.gain /= weight;
    std::erase_if(list_,
                  [](const PlanSensitivity& item) { return !(std::abs(item.gain) > kNegligible); });
    return std::move(list_);
  }

 private:
  std::vector<PlanSensitivity> list_;
};

/// Gains of the rows of path terms that state which figure limits them. An equality holds nothing
/// back.
void add_row_sensitivities(const transcription::NonlinearProgram& program,
                           const transcription::Interval& interval, const Vector& lambda,
                           SensitivitySums& sums) {
  for (const transcription::PathRows& path : interval.path) {
    const transcription::Sensitivity& sensitivity = path.term->sensitivity;
    if (sensitivity.figure.empty()) continue;
    for (int i = 0; i < count_of(path.term->rows); ++i) {
      const int row = path.row + i;
      if (program.row_lower()[row] == program.row_upper()[row]) continue;
      sums.add(sensitivity.figure, sensitivity.unit,
               sensitivity.gain(i, lambda[row], &interval.point(path.point)));
    }
  }
}

/// Gains of the rows of a node term; a value that is imposed there is a figure of the problem too.
void add_node_sensitivities(const transcription::NonlinearProgram::PlacedRows& placed,
                            const Vector& lambda, SensitivitySums& sums) {
  const transcription::Sensitivity& sensitivity = placed.term->sensitivity;
  if (sensitivity.figure.empty()) return;
  for (int i = 0; i < count_of(placed.term->rows); ++i)
    sums.add(sensitivity.figure, sensitivity.unit,
             sensitivity.gain(i, lambda[placed.row + i], nullptr));
}

/// How the usable joint torque grows with the limit that sets it: torque or current of the motor.
void add_torque_sensitivities(const transcription::Problem& problem,
                              const model::PlanarModel& model, int m, double multiplier,
                              SensitivitySums& sums) {
  const model::PlanarMotor motor = limited_motor(problem, model, model.motors[m]);
  const double ratio = motor.gear * motor.efficiency,
               tau = transcription::usable_torque(problem, model, motor) / ratio;
  if (motor.ideal() || tau >= motor.torque_limit * (1.0 - 1e-9)) {
    const bool slides = model.slides(motor);
    sums.add("motor torque", slides ? "N" : "N m", multiplier * ratio);
  } else {
    const double slope = motor.saturation_linear + 3.0 * motor.saturation_cubic * tau * tau;
    sums.add("current", "A", multiplier * ratio / slope);
  }
}

void add_bound_sensitivities(const transcription::NonlinearProgram& program,
                             const NlpResult& result, SensitivitySums& sums) {
  const transcription::Layout& layout = program.layout();

  std::vector<int> columns;
  for (const transcription::IntervalBlock& interval : layout.intervals) {
    for (int m = 0; m < layout.n_u; ++m) {
      columns.push_back(interval.u_first + m);
      if (!layout.held) columns.push_back(interval.u_last + m);
    }
  }

  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());

  for (int k = 0; k < count_of(columns); ++k) {
    const int c = columns[k];
    if (!std::isfinite(layout.upper[c])) continue;
    const int motor = k % layout.n_u;
    add_torque_sensitivities(program.problem(), program.equations().model(), motor,
                             result.lower_multipliers[c] + result.upper_multipliers[c], sums);
  }

  const transcription::NodeBlock& last = layout.nodes.back();
  for (int i = 0; i < 2 * layout.n; ++i) {
    const int c = last.q + i;
    if (layout.lower[c] == layout.upper[c]) continue;
    const double gain = result.upper_multipliers[c] - result.lower_multipliers[c];
    sums.add(fmt::format("bound on {}", layout.names[c]), layout.units[c], gain);
  }
}

/// Bounds of coordinates at nodes, of durations and of what terms added, and rows that hold at one
/// node.
void add_single_limits(const transcription::NonlinearProgram& program, const Vector& x,
                       const Vector& g, const std::vector<double>& starts, LimitList& list) {
  const transcription::Layout& layout = program.layout();
  const auto bound = [&](int c) {
    return active(x[c], layout.lower[c], layout.upper[c], layout.scale[c]);
  };

  std::vector<double> times(layout.nodes.size(), 0.0);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const transcription::IntervalBlock& block = layout.intervals[k];
    times[block.first] = starts[k];
    times[block.last] = starts[k] + program.intervals()[k].length();
  }

  for (std::size_t k = 0; k < layout.nodes.size(); ++k) {
    const transcription::NodeBlock& node = layout.nodes[k];
    const std::string& phase = layout.phases[node.phase].name;
    for (int i = 0; i < layout.n; ++i) {
      const std::string& name = program.equations().model().coordinates[i].name;
      if (bound(node.q + i)) list.add("bound on " + name, phase, times[k], times[k]);
      if (bound(node.v + i)) list.add("bound on " + name + " velocity", phase, times[k], times[k]);
    }
  }

  const double end = times.back();
  for (const transcription::PhaseBlock& phase : layout.phases)
    if (bound(phase.duration)) list.add("bound on duration", phase.name, 0.0, end);
  for (int c = layout.first_extra; c < layout.columns(); ++c)
    if (bound(c)) list.add("bound on " + layout.names[c], "whole plan", 0.0, end);

  for (const transcription::NonlinearProgram::PlacedRows& placed : program.node_rows()) {
    for (int i = 0; i < count_of(placed.term->rows); ++i) {
      const int row = placed.row + i;
      if (active(g[row], program.row_lower()[row], program.row_upper()[row],
                 program.row_scale()[row]))
        list.add(placed.term->rows[i].name, "whole plan", 0.0, end);
    }
  }
}

/// Path constraints and inputs, interval by interval.
void add_path_limits(const transcription::NonlinearProgram& program, const Vector& x,
                     const Vector& g, const std::vector<double>& starts, LimitList& list) {
  const transcription::Layout& layout = program.layout();
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const transcription::Interval& interval = program.intervals()[k];
    const transcription::IntervalBlock& block = layout.intervals[k];

    const std::string& phase = layout.phases[block.phase].name;
    for (const transcription::PathRows& path : interval.path) {
      const double time = starts[k] + 0.5 * path.point * interval.length();
      for (int i = 0; i < count_of(path.term->rows); ++i) {
        const int row = path.row + i;
        if (active(g[row], program.row_lower()[row], program.row_upper()[row],
                   program.row_scale()[row]))
          list.add(path.term->rows[i].name, phase, time, time);
      }
    }

    for (int m = 0; m < layout.n_u; ++m) {
      const int c = block.u_first + m;
      if (!active(x[c], layout.lower[c], layout.upper[c], layout.scale[c])) continue;
      const model::PlanarMotor& motor = program.equations().model().motors[m];
      const char* what = motor.dry_friction > 0.0 ? " torque, dry friction either way" : " torque";
      list.add(motor.joint + what, phase, starts[k], starts[k] + interval.length());
    }
  }
}

}  // namespace

std::vector<PlanLimit> active_limits(transcription::NonlinearProgram& program,
                                     const NlpResult& result) {
  const Vector& x = result.x();
  Vector g(program.rows());
  LimitList list;
  if (!program.constraints(x, g) || !program.evaluate_at(x)) return {};
  const std::vector<double> starts = interval_starts(program);
  add_path_limits(program, x, g, starts, list);
  add_single_limits(program, x, g, starts, list);
  return list.take();
}

void find_sensitivities(Plan& plan) {
  transcription::NonlinearProgram& program = *plan.program;
  name_objective(plan);
  SensitivitySums sums;
  if (!program.evaluate_at(plan.result.x())) return;
  for (const transcription::Interval& interval : program.intervals())
    add_row_sensitivities(program, interval, plan.result.row_multipliers, sums);
  for (const transcription::NonlinearProgram::PlacedRows& placed : program.node_rows()) {
    add_node_sensitivities(placed, plan.result.row_multipliers, sums);
  }
  add_bound_sensitivities(program, plan.result, sums);
  plan.sensitivities = sums.take(plan.objective_weight);
}

}  // namespace jaculus::solver
