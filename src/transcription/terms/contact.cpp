// Terms of contact along the plan. Forces are sums over left and right.

#include <fmt/format.h>

#include <algorithm>

#include "transcription/terms/factories.h"

namespace jaculus::terms {

namespace {

/// Where the foot's force stands among the feet in contact, -1 where it is in the air.
int contact_slot(const PhaseBlock& phase, int foot) {
  const auto it = std::find(phase.feet.begin(), phase.feet.end(), foot);
  return it == phase.feet.end() ? -1 : static_cast<int>(it - phase.feet.begin());
}

/// Friction pyramid of one foot: mu f_z - f_x >= 0 and mu f_z + f_x >= 0, which together hold f_z >= 0.
PathTerm pyramid(const std::string& foot_name, int foot, int slot, double mu, double scale) {
  PathTerm term;
  term.name = "friction of " + foot_name;
  term.kind = LimitKind::friction;
  term.foot = foot;
  for (const char* side : {"forward", "backward"})
    term.rows.push_back({fmt::format("{} friction {}", foot_name, side), "N", {0.0, kInfinity}, scale});
  term.reads.force = true;
  term.evaluate = [slot, mu](const PointView& view, VectorRef values, Matrix* J, const ConstVectorRef*, Matrix*) {
    const double fx = view.point.force[2 * slot], fz = view.point.force[2 * slot + 1];
    values[0] = mu * fz - fx;
    values[1] = mu * fz + fx;
    if (!J) return;
    const int at = view.f_at() + 2 * slot;
    (*J)(0, at) = -1.0;
    (*J)(1, at) = 1.0;
    (*J)(0, at + 1) = (*J)(1, at + 1) = mu;
  };
  return term;
}

/// One component of a foot's force within bounds.
PathTerm force_component(const std::string& name, int slot, int component, const Bounds& bounds, double scale) {
  PathTerm term;
  term.name = name;
  term.rows.push_back({name, "N", bounds, scale});
  term.reads.force = true;
  term.evaluate = [slot, component](const PointView& view, VectorRef values, Matrix* J, const ConstVectorRef*,
                                    Matrix*) {
    values[0] = view.point.force[2 * slot + component];
    if (J) (*J)(0, view.f_at() + 2 * slot + component) = 1.0;
  };
  return term;
}

}  // namespace

void friction(const TermSpec& spec, TermContext& context) {
  spec.node.only({"type", "name", "coefficient", "feet", "phases"});
  const auto own = spec.node.find("coefficient");
  const double mu =
      own ? own->number(dimension::none, {1e-6, 10.0}) : context.problem.friction.value_or(context.model().friction);
  if (!(mu > 0.0))
    throw spec.node.error("friction: no coefficient; give one here, in limits, or in the robot's robot.yaml");
  for (int p : chosen_phases(spec.node, context)) {
    for (int foot : chosen_feet(spec.node, context)) {
      const int slot = contact_slot(context.layout.phases[static_cast<size_t>(p)], foot);
      if (slot < 0) continue;
      const std::string& name = context.model().feet[static_cast<size_t>(foot)].name;
      context.path[static_cast<size_t>(p)].push_back(pyramid(name, foot, slot, mu, weight_scale(context)));
    }
  }
}

void normal_force(const TermSpec& spec, TermContext& context) {
  spec.node.only({"type", "name", "min", "max", "feet", "phases", "skip_first", "skip_last"});
  const auto min = spec.node.find("min"), max = spec.node.find("max");
  if (!min && !max) throw spec.node.error("normal_force: neither `min` nor `max` is given; name at least one");
  const Bounds each{min ? min->number(dimension::force) : -kInfinity, max ? max->number(dimension::force) : kInfinity};
  const auto skip = [&](const char* key) {
    const auto node = spec.node.find(key);
    return node ? node->integer(0, 1000000) : 0;
  };
  for (int p : chosen_phases(spec.node, context)) {
    for (int foot : chosen_feet(spec.node, context)) {
      const int slot = contact_slot(context.layout.phases[static_cast<size_t>(p)], foot);
      if (slot < 0) continue;
      const PlanarPoint& point = context.model().feet[static_cast<size_t>(foot)];
      PathTerm term = force_component(point.name + " normal force", slot, 1,
                                      {each.lower * point.count, each.upper * point.count}, weight_scale(context));
      term.kind = LimitKind::normal_force;
      term.foot = foot;
      const PhaseSpec& phase = context.problem.phases[static_cast<size_t>(p)];
      if (!leave_out(skip("skip_first"), skip("skip_last"), phase, context.problem.transcription.scheme, term))
        throw spec.node.error(
            fmt::format("skip_first and skip_last leave out every point of phase '{}'; allowed: fewer", phase.name));
      context.path[static_cast<size_t>(p)].push_back(term);
    }
  }
}

void force_at_end(const TermSpec& spec, TermContext& context) {
  spec.node.only({"type", "name", "phase", "foot", "normal"});
  const int p = phase_index(spec.node.at("phase"), context), foot = foot_index(spec.node.at("foot"), context);
  const PlanarPoint& point = context.model().feet[static_cast<size_t>(foot)];
  const int slot = contact_slot(context.layout.phases[static_cast<size_t>(p)], foot);
  if (slot < 0) throw spec.node.error(fmt::format("force_at_end: {} is not in contact in this phase", point.name));
  Bounds normal = spec.node.at("normal").bounds(dimension::force);
  normal = {normal.lower * point.count, normal.upper * point.count};
  const auto add = [&](const char* what, int component, const Bounds& bounds) {
    PathTerm term = force_component(fmt::format("{} {} force at the end", point.name, what), slot, component, bounds,
                                    weight_scale(context));
    term.only_last = true;
    context.path[static_cast<size_t>(p)].push_back(term);
  };
  add("normal", 1, normal);
  if (normal.lower == 0.0 && normal.upper == 0.0) {
    // The pyramid shrinks to a point there and loses its interior; its one point is stated instead.
    add("tangential", 0, {0.0, 0.0});
    context.unloaded.emplace_back(p, foot);
  }
}

void swing_clearance(const TermSpec& spec, TermContext& context) {
  spec.node.only({"type", "name", "feet", "phases", "min"});
  const double min = spec.node.at("min").number(dimension::length);
  for (int p : chosen_phases(spec.node, context)) {
    for (int foot : chosen_feet(spec.node, context)) {
      if (contact_slot(context.layout.phases[static_cast<size_t>(p)], foot) >= 0) continue;
      const PlanarPoint& point = context.model().feet[static_cast<size_t>(foot)];
      PathTerm term;
      term.name = "swing clearance of " + point.name;
      term.rows.push_back({point.name + " height", "m", {min, kInfinity}, 0.1});
      term.reads.position = true;
      // A foot takes off from the ground and lands on it: the row holds between.
      term.after = 0.0;
      term.before = 1.0;
      auto f = std::make_shared<PointFunction>(context.equations.tree(), foot_point(context.equations.tree(), foot));
      term.evaluate = [f](const PointView& view, VectorRef values, Matrix* J, const ConstVectorRef* multipliers,
                          Matrix* H) {
        const AbsoluteTree& tree = view.equations.tree();
        values[0] = point_position(f->point, view.point.motion).y();
        const Vec2 up(0.0, 1.0), none = Vec2::Zero();
        if (J) {
          f->gradient.setZero();
          add_point_gradient(tree, view.point.motion, f->point, up, none, f->gradient, f->scratch);
          J->row(0).head(2 * view.n) = f->gradient.transpose();
        }
        if (H)
          add_point_hessian(tree, view.point.motion, f->point, (*multipliers)[0] * up, none,
                            H->topLeftCorner(2 * view.n, 2 * view.n), f->scratch);
      };
      context.path[static_cast<size_t>(p)].push_back(term);
    }
  }
}

}  // namespace jaculus::terms
