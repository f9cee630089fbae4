// Terms of contact along the plan. Forces are sums over left and right.

#include <fmt/format.h>

#include <algorithm>

#include "transcription/terms/common.h"

namespace jaculus::transcription::terms {

namespace {

/// Where the foot's force stands among the feet in contact, -1 where it is in the air.
int contact_slot(const PhaseBlock& phase, int foot) { return index_of(phase.feet, foot); }

/// Friction pyramid of one foot: mu f_z - f_x >= 0 and mu f_z + f_x >= 0, which together hold f_z
/// >= 0.
PathTerm pyramid(const std::string& foot_name, int foot, int slot, double mu, double scale) {
  PathTerm term;
  term.name = "friction of " + foot_name;
  term.loaded_foot = foot;
  for (const char* side : {"forward", "backward"})
    term.rows.push_back(
        {fmt::format("{} friction {}", foot_name, side), "N", {0.0, kInfinity}, scale});
  term.reads.force = true;
  term.linear = true;
  term.evaluate = [slot, mu](const PointView& view, VectorRef values, Matrix* J,
                             const ConstVectorRef*, Matrix*) {
    const double fx = view.point.force[2 * slot], fz = view.point.force[2 * slot + 1];
    values[0] = mu * fz - fx;
    values[1] = mu * fz + fx;
    if (!J) return;
    const int at = view.f_at() + 2 * slot;
    (*J)(0, at) = -1.0;
    (*J)(1, at) = 1.0;
    (*J)(0, at + 1) = (*J)(1, at + 1) = mu;
  };
  term.sensitivity = {"friction", "unit of friction",
                      [slot](int, double multiplier, const components::EquationsPoint* point) {
                        return -multiplier * point->force[2 * slot + 1];
                      }};

  return term;
}

/// One component of a foot's force within bounds.
PathTerm force_component(const std::string& name, int slot, int component, const Bounds& bounds,
                         double scale) {
  PathTerm term;
  term.name = name;
  term.rows.push_back({name, "N", bounds, scale});
  term.reads.force = true;
  term.linear = true;
  term.evaluate = [slot, component](const PointView& view, VectorRef values, Matrix* J,
                                    const ConstVectorRef*, Matrix*) {
    values[0] = view.point.force[2 * slot + component];
    if (J) (*J)(0, view.f_at() + 2 * slot + component) = 1.0;
  };
  return term;
}

void add_friction(const TermSpec& spec, TermContext& context) {
  const double robots = context.problem.friction.value_or(context.model().friction);
  const double mu = spec.values.number_or("coefficient", robots);
  if (!(mu > 0.0))
    throw spec.node.error(
        "friction: no coefficient; give one here, in limits, or in the robot's robot.yaml");

  for (int p : all_named(spec, "phases", context)) {
    for (int foot : all_named(spec, "feet", context)) {
      const int slot = contact_slot(context.layout.phases[p], foot);
      if (slot < 0) continue;
      const std::string& name = context.model().feet[foot].name;
      context.path[p].push_back(pyramid(name, foot, slot, mu, weight_scale(context)));
    }
  }
}

void add_normal_force(const TermSpec& spec, TermContext& context) {
  if (!spec.values.has("min") && !spec.values.has("max"))
    throw spec.node.error("normal_force: neither `min` nor `max` is given; name at least one");
  const Bounds each{spec.values.number_or("min", -kInfinity),
                    spec.values.number_or("max", kInfinity)};
  const int first = spec.values.integer("skip_first"), last = spec.values.integer("skip_last");

  for (int p : all_named(spec, "phases", context)) {
    for (int foot : all_named(spec, "feet", context)) {
      const int slot = contact_slot(context.layout.phases[p], foot);
      if (slot < 0) continue;

      const model::PlanarPoint& point = context.model().feet[foot];
      PathTerm term = force_component(point.name + " normal force", slot, 1,
                                      {each.lower * point.count, each.upper * point.count},
                                      weight_scale(context));
      term.sensitivity = {"normal force a foot", "N",
                          [count = point.count](int, double multiplier, const auto*) {
                            return multiplier * count;
                          }};

      const PhaseSpec& phase = context.problem.phases[p];
      if (!leave_out(first, last, phase, context.problem.transcription.scheme, term))
        throw spec.node.error(fmt::format(
            "skip_first and skip_last leave out every point of phase '{}'; allowed: fewer",
            phase.name));
      context.path[p].push_back(term);
    }
  }
}

void add_force_at_end(const TermSpec& spec, TermContext& context) {
  const int p = named(spec, "phase", context), foot = named(spec, "foot", context);
  const model::PlanarPoint& point = context.model().feet[foot];
  const int slot = contact_slot(context.layout.phases[p], foot);
  if (slot < 0)
    throw spec.node.error(
        fmt::format("force_at_end: {} is not in contact in this phase", point.name));
  const Bounds each = spec.values.interval("normal");
  const Bounds normal = {each.lower * point.count, each.upper * point.count};

  const auto add = [&](const char* what, int component, const Bounds& bounds) {
    PathTerm term = force_component(fmt::format("{} {} force at the end", point.name, what), slot,
                                    component, bounds, weight_scale(context));
    term.only_last = true;
    context.path[p].push_back(term);
  };
  add("normal", 1, normal);

  // The pyramid shrinks to a point there and loses its interior; its one point is stated instead.
  if (normal.lower == 0.0 && normal.upper == 0.0) {
    add("tangential", 0, {0.0, 0.0});
    context.unloaded.emplace_back(p, foot);
  }
}

/// Height of a foot in the air.
PathTerm clearance(const components::Equations& equations, int foot, double min) {
  const std::string& name = equations.model().feet[foot].name;
  PathTerm term;
  term.name = "swing clearance of " + name;
  term.rows.push_back({name + " height", "m", {min, kInfinity}, 0.1});
  term.reads.position = true;
  // A foot takes off from the ground and lands on it: the row holds between.
  term.after = 0.0;
  term.before = 1.0;

  auto f = std::make_shared<PointFunction>(equations.tree(),
                                           dynamics::foot_point(equations.tree(), foot));
  term.evaluate = [f](const PointView& view, VectorRef values, Matrix* J,
                      const ConstVectorRef* multipliers, Matrix* H) {
    const dynamics::AbsoluteTree& tree = view.equations.tree();
    values[0] = dynamics::point_position(f->point, view.point.motion).y();
    const Vec2 up(0.0, 1.0), none = Vec2::Zero();
    if (J) {
      f->gradient.setZero();
      dynamics::add_point_gradient(tree, view.point.motion, f->point, up, none, f->gradient,
                                   f->scratch);
      J->row(0).head(2 * view.n) = f->gradient.transpose();
    }
    if (H)
      dynamics::add_point_hessian(tree, view.point.motion, f->point, (*multipliers)[0] * up, none,
                                  H->topLeftCorner(2 * view.n, 2 * view.n), f->scratch);
  };
  return term;
}

void add_swing_clearance(const TermSpec& spec, TermContext& context) {
  const double min = spec.values.number("min");
  for (int p : all_named(spec, "phases", context)) {
    for (int foot : all_named(spec, "feet", context)) {
      if (contact_slot(context.layout.phases[p], foot) >= 0) continue;
      context.path[p].push_back(clearance(context.equations, foot, min));
    }
  }
}

}  // namespace

TermType friction() {
  return {.name = "friction",
          .meaning = "feet within the friction pyramid |f_x| <= coefficient f_z",
          .keys = {{"coefficient",
                    key::Number{dimension::none, {1e-6, 10.0}},
                    "of Coulomb friction",
                    {.words = "limits.friction"}},
                   feet_key(),
                   phases_key()},
          .example = "coefficient: 0.4",
          .make = add_friction};
}

TermType normal_force() {
  return {.name = "normal_force",
          .meaning = "normal force of one foot, left or right, within bounds",
          .keys = {{"min",
                    key::Number{dimension::force},
                    "least force; min or max must be there",
                    {.words = "none"}},
                   {"max", key::Number{dimension::force}, "largest force", {.words = "none"}},
                   feet_key(),
                   phases_key(),

                   {"skip_first",
                    key::Integer{0, 1000000},
                    "collocation points at the start of a phase that are left out, counted on the "
                    "grid as stated, not as refined",
                    {.value = "0"}},
                   {"skip_last",
                    key::Integer{0, 1000000},
                    "the same at its end: what lies between them in time stays left out on finer "
                    "grids",
                    {.value = "0"}}},
          .example = "min: 8 N, max: 200 N, skip_last: 2",
          .make = add_normal_force};
}

TermType force_at_end() {
  return {.name = "force_at_end",
          .meaning = "normal force of one foot, left or right, at the end of a phase",
          .keys = {{"phase", key::Name{key::Of::phase}, "the phase at whose end it counts"},
                   {"foot", key::Name{key::Of::foot}, "the foot"},
                   {"normal", key::Interval{dimension::force}, "a number or [lower, upper]"}},
          .example = "phase: all_feet, foot: front_foot, normal: [0 N, 5 N]",
          .make = add_force_at_end};
}

TermType swing_clearance() {
  return {.name = "swing_clearance",
          .meaning = "least height of feet while they are in the air",
          .keys = {{"min", key::Number{dimension::length}, "over the ground"},
                   feet_key(),
                   phases_key()},
          .example = "min: 0.01 m, feet: [front_foot], phases: [rear_feet]",
          .make = add_swing_clearance};
}

}  // namespace jaculus::transcription::terms
