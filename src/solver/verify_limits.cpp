#include "solver/verify_limits.h"

#include <algorithm>
#include <cmath>

namespace jaculus::detail {

namespace {

constexpr double kFootScale = 0.1;  // [m], as the rows that put feet on the ground have it

}  // namespace

LimitWatch::LimitWatch(const Programme& programme) : programme_(programme) {}

void LimitWatch::check(const std::string& name, const std::string& unit, double value, const Bounds& bounds,
                       double scale, bool of_foot) {
  const bool above = value > bounds.upper;
  const double limit = above ? bounds.upper : bounds.lower, amount = above ? value - limit : limit - value;
  if (amount <= 1e-6 * scale) return;
  LimitExcess& worst = worst_[name];
  if (amount / scale <= worst.scaled || std::isnan(worst.scaled)) return;  // a value that is no number stays the worst
  worst = {name, unit, phase_, time_, value, limit, amount, amount / scale, of_foot};
}

void LimitWatch::begin_phase(const EquationsPoint& point) {
  const AbsoluteTree& tree = programme_.equations().tree();
  place_.clear();
  for (size_t f = 0; f < tree.feet.size(); ++f)
    place_.push_back(foot_position(tree, point.motion, static_cast<int>(f)));
}

void LimitWatch::look(int k, double s, double time, const Vector& u, EquationsPoint& point) {
  const Layout& layout = programme_.layout();
  const IntervalBlock& block = layout.intervals[static_cast<size_t>(k)];
  phase_ = layout.phases[static_cast<size_t>(block.phase)].name;
  time_ = time;
  look_at_terms(k, s, u, point);
  look_at_bounds(k, u, point);
  look_at_feet(point);
}

void LimitWatch::look_at_terms(int k, double s, const Vector& u, EquationsPoint& point) {
  const Layout& layout = programme_.layout();
  const IntervalBlock& block = layout.intervals[static_cast<size_t>(k)];
  const PointView view{programme_.equations(), point, u, layout.n, layout.n_u};
  for (const PathTerm& term : programme_.path_terms()[static_cast<size_t>(block.phase)]) {
    if (!term.holds_at(block.begin + s * block.fraction)) continue;
    Vector values(static_cast<int>(term.rows.size()));
    term.evaluate(view, values, nullptr, nullptr, nullptr);
    for (size_t i = 0; i < term.rows.size(); ++i)
      check(term.rows[i].name, term.rows[i].unit, values[static_cast<int>(i)], term.rows[i].bounds, term.rows[i].scale);
  }
}

/// The looser of the bounds of two columns: what holds at one node only, as end conditions do, is no limit beside it.
Bounds LimitWatch::hull(int first, int second) const {
  const Layout& layout = programme_.layout();
  return {std::min(layout.lower[first], layout.lower[second]), std::max(layout.upper[first], layout.upper[second])};
}

void LimitWatch::look_at_bounds(int k, const Vector& u, const EquationsPoint& point) {
  const Layout& layout = programme_.layout();
  const IntervalBlock& block = layout.intervals[static_cast<size_t>(k)];
  const NodeBlock &first = layout.nodes[static_cast<size_t>(block.first)],
                  &last = layout.nodes[static_cast<size_t>(block.last)];
  const PlanarModel& model = programme_.equations().model();
  const auto unit = [&](int column) { return layout.units[static_cast<size_t>(column)]; };
  for (int i = 0; i < layout.n; ++i) {
    const std::string& name = model.coordinates[static_cast<size_t>(i)].name;
    const int q = first.q + i, v = first.v + i;
    check(name + " position", unit(q), point.q[i], hull(q, last.q + i), layout.scale[q]);
    check(name + " velocity", unit(v), point.v[i], hull(v, last.v + i), layout.scale[v]);
  }
  for (int i = 0; i < layout.n_u; ++i) {
    const int column = block.u_first + i;
    check(model.motors[static_cast<size_t>(i)].joint + " torque", unit(column), u[i], hull(column, block.u_last + i),
          layout.scale[column]);
  }
}

void LimitWatch::look_at_feet(const EquationsPoint& point) {
  const AbsoluteTree& tree = programme_.equations().tree();
  for (size_t f = 0; f < tree.feet.size(); ++f) {
    const std::string& name = programme_.equations().model().feet[f].name;
    const Vec2 position = foot_position(tree, point.motion, static_cast<int>(f));
    const bool stands = std::find(point.feet.begin(), point.feet.end(), static_cast<int>(f)) != point.feet.end();
    if (stands) {
      check(name + " slip", "m", position.x() - place_[f].x(), {0.0, 0.0}, kFootScale, true);
      check(name + " off the ground", "m", position.y(), {0.0, 0.0}, kFootScale, true);
    } else {
      check(name + " below ground", "m", position.y(), {0.0, kInfinity}, kFootScale, true);
    }
  }
}

std::vector<LimitExcess> LimitWatch::excesses() const {
  std::vector<LimitExcess> sorted;
  for (const auto& [name, excess] : worst_) sorted.push_back(excess);
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.scaled > b.scaled; });
  return sorted;
}

}  // namespace jaculus::detail
