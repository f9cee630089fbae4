// Which limits are active when, and what they cost. Formulas at the top of plan.h.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "jaculus/components/motor.h"
#include "jaculus/solver/plan.h"

namespace jaculus {
namespace {

constexpr double kActive = 1e-4;   // of the scale: nearer to a limit than this counts as active
constexpr double kNoPrice = 1e-6;  // smallest price that is shown

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

std::vector<double> interval_starts(const Programme& programme) {
  std::vector<double> starts;
  double time = 0.0;
  for (const Interval& interval : programme.intervals()) {
    starts.push_back(time);
    time += interval.length();
  }
  return starts;
}

/// Unit and weight of the objective where all its terms of the wanted direction are of one type.
void name_objective(Plan& plan) {
  static const std::map<std::string, std::string> kUnits = {
      {"mean_acceleration", "m/s^2"},  {"final_velocity", "m/s"}, {"distance", "m"}, {"height", "m"}, {"time", "s"},
      {"torque_squared", "N^2 m^2 s"}, {"electrical_energy", "J"}};
  const TermSpec* main = nullptr;
  for (const TermSpec& term : plan.programme->problem().objective) {
    if (term.weight <= 0.0) continue;  // the lesser part, in the other direction
    if (main != nullptr) return;
    main = &term;
  }
  if (main == nullptr) return;
  const auto unit = kUnits.find(main->type);
  if (unit == kUnits.end()) return;
  plan.objective_unit = unit->second;
  plan.objective_weight = main->weight;
}

/// Improvement of the objective by limit, summed over rows, in order of first appearance.
class PriceSums {
 public:
  void add(const std::string& limit, const std::string& unit, double gain) {
    for (PlanPrice& price : list_) {
      if (price.limit != limit) continue;
      price.gain += gain;
      return;
    }
    list_.push_back({limit, unit, gain});
  }
  std::vector<PlanPrice> take(double weight) {
    for (PlanPrice& price : list_) price.gain /= weight;
    std::erase_if(list_, [](const PlanPrice& price) { return !(std::abs(price.gain) > kNoPrice); });
    return std::move(list_);
  }

 private:
  std::vector<PlanPrice> list_;
};

void add_row_prices(const Programme& programme, const Interval& interval, const Vector& lambda, PriceSums& sums) {
  for (const PathRows& path : interval.path) {
    const PathTerm& term = *path.term;
    for (int i = 0; i < static_cast<int>(term.rows.size()); ++i) {
      const double multiplier = lambda[path.row + i];
      if (programme.row_lower()[path.row + i] == programme.row_upper()[path.row + i]) continue;
      if (term.kind == LimitKind::voltage) {
        sums.add("voltage", "V", std::abs(multiplier));
      } else if (term.kind == LimitKind::friction) {
        const EquationsPoint& point = interval.point(path.point);
        const auto slot = std::find(point.feet.begin(), point.feet.end(), term.foot) - point.feet.begin();
        sums.add("friction", "unit of friction", -multiplier * point.force[2 * slot + 1]);
      } else if (term.kind == LimitKind::normal_force) {
        const int count = programme.equations().model().feet[static_cast<std::size_t>(term.foot)].count;
        sums.add("normal force a foot", "N", multiplier * count);
      }
    }
  }
}

/// How the usable joint torque grows with the limit that sets it: torque or current of the motor.
void add_torque_price(const Problem& problem, PlanarMotor motor, double multiplier, PriceSums& sums) {
  if (problem.torque) motor.torque_limit = *problem.torque;
  if (problem.current) motor.current_limit = *problem.current;
  const double ratio = motor.gear * motor.efficiency, tau = usable_torque(problem, motor) / ratio;
  if (motor.ideal() || tau >= motor.torque_limit * (1.0 - 1e-9)) {
    sums.add("motor torque", "N m", multiplier * ratio);
  } else {
    const double slope = motor.saturation_linear + 3.0 * motor.saturation_cubic * tau * tau;
    sums.add("current", "A", multiplier * ratio / slope);
  }
}

void add_bound_prices(const Programme& programme, const NlpResult& result, PriceSums& sums) {
  const Layout& layout = programme.layout();
  const std::vector<PlanarMotor>& motors = programme.equations().model().motors;
  std::vector<int> columns;
  for (const IntervalBlock& interval : layout.intervals) {
    for (int m = 0; m < layout.n_u; ++m) {
      columns.push_back(interval.u_first + m);
      if (!layout.held) columns.push_back(interval.u_last + m);
    }
  }
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const int c = columns[k];
    if (!std::isfinite(layout.upper[c])) continue;
    const std::size_t motor = k % static_cast<std::size_t>(layout.n_u);
    add_torque_price(programme.problem(), motors[motor], result.lower_multipliers[c] + result.upper_multipliers[c],
                     sums);
  }
  const NodeBlock& last = layout.nodes.back();
  for (int i = 0; i < 2 * layout.n; ++i) {
    const int c = last.q + i;
    if (layout.lower[c] == layout.upper[c]) continue;
    const double gain = result.upper_multipliers[c] - result.lower_multipliers[c];
    sums.add(fmt::format("bound on {}", layout.names[static_cast<std::size_t>(c)]),
             layout.units[static_cast<std::size_t>(c)], gain);
  }
}

/// Bounds of coordinates at nodes, of durations and of what terms added, and rows that hold at one node.
void add_single_limits(const Programme& programme, const Vector& x, const Vector& g, const std::vector<double>& starts,
                       LimitList& list) {
  const Layout& layout = programme.layout();
  const auto bound = [&](int c) { return active(x[c], layout.lower[c], layout.upper[c], layout.scale[c]); };
  std::vector<double> times(layout.nodes.size(), 0.0);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const IntervalBlock& block = layout.intervals[k];
    times[static_cast<std::size_t>(block.first)] = starts[k];
    times[static_cast<std::size_t>(block.last)] = starts[k] + programme.intervals()[k].length();
  }
  for (std::size_t k = 0; k < layout.nodes.size(); ++k) {
    const NodeBlock& node = layout.nodes[k];
    const std::string& phase = layout.phases[static_cast<std::size_t>(node.phase)].name;
    for (int i = 0; i < layout.n; ++i) {
      const std::string& name = programme.equations().model().coordinates[static_cast<std::size_t>(i)].name;
      if (bound(node.q + i)) list.add("bound on " + name, phase, times[k], times[k]);
      if (bound(node.v + i)) list.add("bound on " + name + " velocity", phase, times[k], times[k]);
    }
  }
  const double end = times.back();
  for (const PhaseBlock& phase : layout.phases)
    if (bound(phase.duration)) list.add("bound on duration", phase.name, 0.0, end);
  for (int c = layout.first_extra; c < layout.columns(); ++c)
    if (bound(c)) list.add("bound on " + layout.names[static_cast<std::size_t>(c)], "whole plan", 0.0, end);
  for (const Programme::PlacedRows& placed : programme.node_rows()) {
    for (int i = 0; i < static_cast<int>(placed.term->rows.size()); ++i) {
      const int row = placed.row + i;
      if (active(g[row], programme.row_lower()[row], programme.row_upper()[row], programme.row_scale()[row]))
        list.add(placed.term->rows[static_cast<std::size_t>(i)].name, "whole plan", 0.0, end);
    }
  }
}

/// Path constraints and inputs, interval by interval.
void add_path_limits(const Programme& programme, const Vector& x, const Vector& g, const std::vector<double>& starts,
                     LimitList& list) {
  const Layout& layout = programme.layout();
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const Interval& interval = programme.intervals()[k];
    const IntervalBlock& block = layout.intervals[k];
    const std::string& phase = layout.phases[static_cast<std::size_t>(block.phase)].name;
    for (const PathRows& path : interval.path) {
      const double time = starts[k] + 0.5 * path.point * interval.length();
      for (int i = 0; i < static_cast<int>(path.term->rows.size()); ++i) {
        const int row = path.row + i;
        if (active(g[row], programme.row_lower()[row], programme.row_upper()[row], programme.row_scale()[row]))
          list.add(path.term->rows[static_cast<std::size_t>(i)].name, phase, time, time);
      }
    }
    for (int m = 0; m < layout.n_u; ++m) {
      const int c = block.u_first + m;
      if (active(x[c], layout.lower[c], layout.upper[c], layout.scale[c]))
        list.add(programme.equations().model().motors[static_cast<std::size_t>(m)].joint + " torque", phase, starts[k],
                 starts[k] + interval.length());
    }
  }
}

}  // namespace

std::vector<PlanLimit> active_limits(Programme& programme, const NlpResult& result) {
  const Vector& x = result.x();
  Vector g(programme.rows());
  LimitList list;
  if (!programme.constraints(x, g) || !programme.evaluate_at(x)) return {};
  const std::vector<double> starts = interval_starts(programme);
  add_path_limits(programme, x, g, starts, list);
  add_single_limits(programme, x, g, starts, list);
  return list.take();
}

void price_limits(Plan& plan) {
  Programme& programme = *plan.programme;
  name_objective(plan);
  PriceSums sums;
  if (!programme.evaluate_at(plan.result.x())) return;
  for (const Interval& interval : programme.intervals())
    add_row_prices(programme, interval, plan.result.row_multipliers, sums);
  for (const Programme::PlacedRows& placed : programme.node_rows()) {
    if (placed.term->kind != LimitKind::touchdown_pitch) continue;
    const double multiplier = plan.result.row_multipliers[placed.row + placed.term->kind_row];
    sums.add("touchdown pitch", "deg", multiplier * std::numbers::pi / 180.0);
  }
  add_bound_prices(programme, plan.result, sums);
  plan.prices = sums.take(plan.objective_weight);
}

}  // namespace jaculus
