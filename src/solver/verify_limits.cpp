#include "solver/verify_limits.h"

#include <algorithm>
#include <cmath>

#include "jaculus/components/motor.h"

namespace jaculus::solver::detail {

namespace {

constexpr double kFootScale = 0.1;  // [m], as the rows that put feet on the ground have it

}  // namespace

LimitMonitor::LimitMonitor(const transcription::NonlinearProgram& program)
    : program_(program), by_interval_(Vector::Zero(count_of(program.layout().intervals))) {}

void LimitMonitor::check(const std::string& name, const std::string& unit, double value,
                         const Bounds& bounds, double scale, bool of_foot) {
  const bool above = value > bounds.upper;
  const double limit = above ? bounds.upper : bounds.lower,
               amount = above ? value - limit : limit - value;
  if (amount <= 1e-6 * scale) return;
  double& here = by_interval_[interval_];
  if (!of_foot && !(amount / scale <= here)) here = std::isnan(amount) ? kInfinity : amount / scale;
  LimitExcess& worst = worst_[name];
  // a value that is no number stays the worst
  if (amount / scale <= worst.scaled || std::isnan(worst.scaled)) return;
  worst = {name, unit, phase_, time_, value, limit, amount, amount / scale, of_foot};
}

void LimitMonitor::begin_phase(const components::EquationsPoint& point) {
  const dynamics::AbsoluteTree& tree = program_.equations().tree();
  place_.clear();
  for (int f = 0; f < count_of(tree.feet); ++f)
    place_.push_back(dynamics::foot_position(tree, point.motion, f));
}

void LimitMonitor::check_point(int k, double s, double time, const Vector& u,
                               components::EquationsPoint& point) {
  const transcription::Layout& layout = program_.layout();
  const transcription::IntervalBlock& block = layout.intervals[k];
  interval_ = k;
  phase_ = layout.phases[block.phase].name;
  time_ = time;
  check_terms(k, s, u, point);
  check_bounds(k, u, point);
  check_feet(point);
}

void LimitMonitor::check_terms(int k, double s, const Vector& u,
                               components::EquationsPoint& point) {
  const transcription::Layout& layout = program_.layout();
  const transcription::IntervalBlock& block = layout.intervals[k];
  const transcription::PointView view{program_.equations(), point, u, layout.n, layout.n_u};
  for (const transcription::PathTerm& term : program_.path_terms()[block.phase]) {
    if (!term.holds_at(block.begin + s * block.fraction)) continue;
    Vector values(count_of(term.rows));
    term.evaluate(view, values, nullptr, nullptr, nullptr);
    for (int i = 0; i < count_of(term.rows); ++i)
      check(term.rows[i].name, term.rows[i].unit, values[i], term.rows[i].bounds,
            term.rows[i].scale);
  }
}

/// The looser of the bounds of two columns: what holds at one node only, as end conditions do, is
/// no limit beside it.
Bounds LimitMonitor::hull(int first, int second) const {
  const transcription::Layout& layout = program_.layout();
  return {std::min(layout.lower[first], layout.lower[second]),
          std::max(layout.upper[first], layout.upper[second])};
}

void LimitMonitor::check_bounds(int k, const Vector& u, const components::EquationsPoint& point) {
  const transcription::Layout& layout = program_.layout();
  const transcription::IntervalBlock& block = layout.intervals[k];
  const transcription::NodeBlock &first = layout.nodes[block.first],
                                 &last = layout.nodes[block.last];
  const model::PlanarModel& model = program_.equations().model();
  const auto unit = [&](int column) { return layout.units[column]; };
  for (int i = 0; i < layout.n; ++i) {
    const std::string& name = model.coordinates[i].name;
    const int q = first.q + i, v = first.v + i;
    check(name + " position", unit(q), point.q[i], hull(q, last.q + i), layout.scale[q]);
    check(name + " velocity", unit(v), point.v[i], hull(v, last.v + i), layout.scale[v]);
  }
  check_torques(block, u, point);
}

/// The motor's torque is the input and what it gives against dry friction at this rate; an input is
/// bounded by what all of that friction leaves.
void LimitMonitor::check_torques(const transcription::IntervalBlock& block, const Vector& u,
                                 const components::EquationsPoint& point) {
  const transcription::Layout& layout = program_.layout();
  const model::PlanarModel& model = program_.equations().model();
  for (int m = 0; m < layout.n_u; ++m) {
    const model::PlanarMotor& motor = model.motors[m];
    const int column = block.u_first + m;
    const double rate = model.joint_map.row(motor.body).dot(point.v);
    const double torque = u[m] + components::against_dry_friction(motor, rate).value;
    Bounds limit = hull(column, block.u_last + m);
    limit.lower -= motor.dry_friction;
    limit.upper += motor.dry_friction;
    check(motor.joint + " torque", layout.units[column], torque, limit,
          layout.scale[column] + motor.dry_friction);
  }
}

void LimitMonitor::check_feet(const components::EquationsPoint& point) {
  const dynamics::AbsoluteTree& tree = program_.equations().tree();
  for (int f = 0; f < count_of(tree.feet); ++f) {
    const std::string& name = program_.equations().model().feet[f].name;
    const Vec2 position = dynamics::foot_position(tree, point.motion, f);
    const bool stands = std::find(point.feet.begin(), point.feet.end(), f) != point.feet.end();
    if (stands) {
      check(name + " slip", "m", position.x() - place_[f].x(), {0.0, 0.0}, kFootScale, true);
      check(name + " off the ground", "m", position.y(), {0.0, 0.0}, kFootScale, true);
    } else {
      check(name + " below ground", "m", position.y(), {0.0, kInfinity}, kFootScale, true);
    }
  }
}

std::vector<LimitExcess> LimitMonitor::excesses() const {
  std::vector<LimitExcess> sorted;
  for (const auto& [name, excess] : worst_) sorted.push_back(excess);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.scaled > b.scaled; });
  return sorted;
}

}  // namespace jaculus::solver::detail
