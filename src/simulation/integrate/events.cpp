#include "simulation/integrate/events.h"

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

#include "simulation/contact/transitions.h"

namespace jaculus::simulation::detail {

namespace {

using Kind = EventFunctionKind;

/// Of those that need no forces, and of a depth.
double motion_value(const EventFunction& f, const std::vector<ContactState>& contacts) {
  const ContactState& c = contacts[f.contact];
  if (f.kind == Kind::gap) return c.gap;
  if (f.kind == Kind::depth) return -c.gap;
  return slip_sign(f.mode) * c.tangential_rate;
}

double value(const PlantEquations& equations, const EventFunction& f, const Evaluation& at) {
  const double tangential = at.lambda[2 * f.contact], normal = at.lambda[2 * f.contact + 1];
  const double mu = equations.unilaterals()[f.contact].mu;
  switch (f.kind) {
    case Kind::lift:
      return normal;
    case Kind::cone_plus:
      return mu * normal - tangential;
    case Kind::cone_minus:
      return mu * normal + tangential;
    case Kind::gap:
    case Kind::depth:
    case Kind::slide:
      break;
  }
  return motion_value(f, at.contacts);
}

/// A step on whose dense output event functions are evaluated.
struct Search {
  PlantEquations& equations;
  Stepper& stepper;
  const Step& step;
  const std::vector<Touch>& modes;
  State y, dydt;  ///< at an instant within it

  /// A function's value at t; NaN where the equations fail.
  double value_at(const EventFunction& f, double t) {
    stepper.state_at(rates_of(equations, modes), step, t, y);
    if (f.needs_forces()) {
      const Evaluation* at = equations.evaluate(t, y, modes, dydt);
      return at != nullptr ? value(equations, f, *at) : kNaN;
    }
    const std::vector<ContactState>* contacts = equations.contacts(y);
    return contacts != nullptr ? motion_value(f, *contacts) : kNaN;
  }
  /// The same, raised; minus its tolerance where the equations fail. Where zero is looked for that
  /// is a crossing; the bottom of a dip, which must lie below it, is then taken for none.
  double raised(const EventFunction& f, double t, double shift) {
    const double found = value_at(f, t);
    return std::isnan(found) ? -f.tolerance : found + shift;
  }
};

/// The instant within the step and before `until` at which f passes zero, or has just passed its
/// tolerance where it began below zero.
double first_crossing(Search& search, const EventFunction& f, double until) {
  const double t = search.step.t;
  // Where it is clearly positive at the start, zero itself is looked for.
  const double shift = f.at_start > f.tolerance ? 0.0 : f.tolerance;
  double from = t, at_from = f.at_start + shift;

  // Just off a contact: the bracket begins where the gap has opened.
  if (f.kind == Kind::gap) {
    for (double share = 1e-9; share < 0.9 && at_from <= 0.0; share *= 4.0) {
      from = t + share * (until - t);
      at_from = search.raised(f, from, shift);
    }
  }
  if (at_from <= 0.0 || f.at_end + shift > 0.0) return t;

  std::uintmax_t iterations = 80;
  const auto close = [](double a, double b) { return b - a < 1e-12; };
  const auto root =
      boost::math::tools::toms748_solve([&](double at) { return search.raised(f, at, shift); },
                                        from, until, at_from, f.at_end + shift, close, iterations);
  return root.second;
}

/// An instant at which a gap that is open at both ends of the step is closed, where there is one.
std::optional<double> dip(const EventFunction& f, const Step& step,
                          const std::vector<ContactState>& contacts) {
  const double rate = contacts[f.contact].normal_rate;
  if (f.kind != Kind::gap || !(f.rate_at_start < 0.0 && rate > 0.0)) return std::nullopt;
  const double share = f.rate_at_start / (f.rate_at_start - rate);
  if (f.at_start + 0.75 * f.rate_at_start * share * step.length > 0.0) return std::nullopt;
  return step.t + share * step.length;
}

}  // namespace

RightHandSide rates_of(PlantEquations& equations, const std::vector<Touch>& modes) {
  return [&](double t, const State& y, State& dydt) {
    return equations.evaluate(t, y, modes, dydt) != nullptr;
  };
}

void list_functions(const PlantEquations& equations, const std::vector<Touch>& modes,
                    double contact_tolerance, std::vector<EventFunction>& out) {
  const double gap = 1e-3 * contact_tolerance, force = 1e-9 * equations.force_scale();
  out.clear();

  for (int i = 0; i < count_of(modes); ++i) {
    const Touch mode = modes[i];
    const auto add = [&](Kind kind, double tolerance) {
      out.push_back({kind, i, mode, tolerance});
    };
    if (mode == Touch::open) {
      add(Kind::gap, gap);
      continue;
    }
    if (equations.compliant(i)) {
      add(Kind::depth, gap);
      continue;
    }
    add(Kind::lift, force);
    if (equations.unilaterals()[i].stop()) continue;
    if (mode == Touch::stick) {
      add(Kind::cone_plus, force);
      add(Kind::cone_minus, force);
    } else {
      add(Kind::slide, 0.5 * kStill);
    }
  }
}

bool begin(const PlantEquations& equations, const Evaluation& at,
           std::vector<EventFunction>& functions) {
  bool sound = true;
  for (EventFunction& f : functions) {
    f.at_start = f.at_end = value(equations, f, at);
    if (f.kind == Kind::gap) f.rate_at_start = at.contacts[f.contact].normal_rate;
    sound = sound && (!f.needs_forces() || f.at_start >= -f.tolerance);
  }
  return sound;
}

StepEvents find_events(PlantEquations& equations, Stepper& stepper, const Step& step,
                       const Evaluation& at, const std::vector<Touch>& modes,
                       std::vector<EventFunction>& functions) {
  struct Suspect {
    EventFunction* function;
    double until;  ///< where it is below zero, or may be
  };
  std::vector<Suspect> suspects;
  for (EventFunction& f : functions) {
    f.at_end = value(equations, f, at);
    if (f.at_end < -f.tolerance)
      suspects.push_back({&f, step.end});
    else if (const auto bottom = dip(f, step, at.contacts))
      suspects.push_back({&f, *bottom});
  }
  if (suspects.empty()) return {};

  Search search{equations, stepper, step, modes, State(step.y.size()), State(step.y.size())};
  StepEvents events{std::nullopt, true};
  for (const auto& [f, until] : suspects) {
    if (until != step.end) {
      f->at_end = search.raised(*f, until, 0.0);
      if (f->at_end >= -f->tolerance) continue;
    }
    const double crossing = first_crossing(search, *f, until);
    if (!events.first || crossing < events.first->time) events.first = Occurrence{*f, crossing};
  }
  return events;
}

}  // namespace jaculus::simulation::detail
