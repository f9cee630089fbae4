#include "studies/tail_design.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace jaculus::studies {
namespace {

constexpr double kSlack = 1.0 + 1e-12;

struct Breaks {
  bool mass, length, width;
  Breaks(const TailDesign& d, const TailLimits& l)
      : mass(d.mass > l.mass * kSlack),
        length(d.length > l.stowed_length * kSlack),
        width(d.width > l.width * kSlack) {}
  [[nodiscard]] bool any() const { return mass || length || width; }
};

std::vector<std::string> binding(const TailDesign& design, const std::vector<TailDesign>& beyond,
                                 const TailLimits& limits, bool heaviest) {
  bool mass = false, length = false, width = false;
  for (const TailDesign& other : beyond) {
    if (!(other.effectiveness > design.effectiveness)) continue;
    const Breaks b(other, limits);
    const bool no_heavier = other.mass <= design.mass * kSlack;
    length |= b.length && !b.mass && !b.width && no_heavier;
    width |= b.width && !b.mass && !b.length && no_heavier;
    mass |= b.mass && !b.length && !b.width && heaviest;
  }
  std::vector<std::string> names;
  if (mass) names.emplace_back("mass budget");
  if (length) names.emplace_back("stowed length");
  if (width) names.emplace_back("width");
  if (!design.search_bound.empty()) names.emplace_back("gear, " + design.search_bound + " bound");
  if (design.shaft <= 0.0) names.emplace_back("no shaft left to give up");
  return names;
}

}  // namespace

double tail_mass(const TailMaterial& m, double length, double shaft, double width) {
  const double scoop = 0.5 * std::numbers::pi * width * (length - shaft);
  const double ends = 0.25 * std::numbers::pi * width * width;
  return m.tube * length + m.film * (scoop + ends) + m.mount;
}

double tail_inertia(const TailMaterial& m, double length, double shaft, double width) {
  const double cube = length * length * length;
  const double scoop = 0.5 * std::numbers::pi * width * (cube - shaft * shaft * shaft) / 3.0;
  const double ends = 0.125 * std::numbers::pi * width * width * (shaft * shaft + length * length);
  return m.tube * cube / 3.0 + m.film * (scoop + ends);
}

TailDesign evaluate_design(const ReorientationSetup& base, const TailMaterial& material,
                           double length, double shaft, double width, const SearchSpace& gears) {
  TailDesign d;
  d.length = length;
  d.shaft = shaft;
  d.width = width;
  d.mass = tail_mass(material, length, shaft, width);
  d.inertia = tail_inertia(material, length, shaft, width);

  ReorientationSetup setup = base;
  setup.tail_length = length;
  setup.tail_shaft = shaft;
  setup.tail_width = width;
  setup.tail_inertia = d.inertia;
  setup.normalised_inertia = setup.shaft_ratio = kNaN;

  ReorientationCase c = to_case(setup);
  const SearchResult best = maximise(gears, [&](double gear) {
    c.motor.gear = gear;
    const ReorientationResult r = simulate_reorientation(c);
    return r.converged ? r.effectiveness : kNaN;
  });

  d.gear = best.argument;
  d.search_bound = best.bound;
  d.effectiveness = kNaN;

  if (std::isnan(best.argument)) return d;
  c.motor.gear = best.argument;
  const ReorientationResult r = simulate_reorientation(c, 1e-2 * kReorientationTolerance);
  d.effectiveness = r.converged ? r.effectiveness : kNaN;
  d.body_angle = std::abs(r.body_angle);

  return d;
}

std::vector<TailDesign> pareto_front(const std::vector<TailDesign>& designs,
                                     const TailLimits& limits) {
  std::vector<TailDesign> allowed, beyond;
  for (const TailDesign& d : designs) {
    if (!std::isnan(d.effectiveness)) (Breaks(d, limits).any() ? beyond : allowed).push_back(d);
  }
  std::stable_sort(allowed.begin(), allowed.end(), [](const TailDesign& a, const TailDesign& b) {
    return a.mass != b.mass ? a.mass < b.mass : a.effectiveness > b.effectiveness;
  });
  std::vector<TailDesign> front;
  for (const TailDesign& d : allowed) {
    if (front.empty() || d.effectiveness > front.back().effectiveness) front.push_back(d);
  }
  for (std::size_t i = 0; i < front.size(); ++i) {
    front[i].binding = binding(front[i], beyond, limits, i + 1 == front.size());
  }
  return front;
}

}  // namespace jaculus::studies
