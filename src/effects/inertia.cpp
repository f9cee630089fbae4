// Masses where the model does not have them, and where gravity pulls them.

#include "effects/families.h"

namespace jaculus::effects {
namespace {

using Overrides = std::vector<ModelOverride>;
using EditBody = void (*)(const Vector&, PlanarBody&);

void add_values(const PlanarBody& body, Overrides& values) {
  values.emplace_back("bodies." + body.name + ".mass", text_of(body.mass));
  values.emplace_back("bodies." + body.name + ".com", text_of(body.com));
  values.emplace_back("bodies." + body.name + ".inertia", text_of(body.inertia));
}

/// Apply and overrides of an effect that edits some bodies: the same edit for both.
void edit_bodies(Effect& effect, std::function<std::vector<int>(const PlanarModel&)> select,
                 EditBody edit) {
  effect.apply = [select, edit](const Vector& theta, Plant& plant) {
    for (const int b : select(plant.model)) edit(theta, plant.model.bodies[b]);
  };
  effect.overrides = [select, edit](const Vector& theta, const PlanarModel& model) {
    Overrides values;
    for (const int b : select(model)) {
      PlanarBody body = model.bodies[b];
      edit(theta, body);
      add_values(body, values);
    }
    return values;
  };
}

Effect effect_on_base(const std::string& name, const std::string& caption, EditBody edit) {
  Effect effect;
  effect.name = name;
  effect.caption = caption;
  effect.where = {Component::body};
  effect.excited_by = {ExperimentKind::leap, ExperimentKind::self_righting};
  effect.applies = [](const PlanarModel& model) {
    return base_moves(model) && model.bodies.front().mass > 0.0;
  };
  edit_bodies(
      effect, [](const PlanarModel&) { return std::vector<int>{0}; }, edit);
  return effect;
}

/// The same edit of every link beyond a scope's joints.
Effect on_links(const JointScope& scope, const std::string& kind, const std::string& caption,
                EditBody edit) {
  Effect effect;
  effect.name = scope.link_prefix + "_" + kind;
  effect.caption = caption + " of every link beyond " + scope.caption + " is other than stated";
  effect.where = scope.links_where;
  effect.excited_by = scope.excited_by;
  effect.joints = joints_of(scope);
  effect.applies = [select = scope.select](const PlanarModel& model) {
    return !select(model).joints.empty();
  };
  const auto links = [select = scope.select](const PlanarModel& model) {
    return select(model).bodies;
  };
  edit_bodies(effect, links, edit);
  return effect;
}

/// A point mass at `place` in the body's frame [m].
void add_mass(PlanarBody& body, double mass, const Vec2& place) {
  if (mass == 0.0) return;

  const double total = body.mass + mass;
  body.inertia += body.mass * mass / total * (place - body.com).squaredNorm();
  body.com = (body.mass * body.com + mass * place) / total;
  body.mass = total;
}

Effect rotor_inertia(const JointScope& scope) {
  const double scale = scope.usual.inertia;
  Effect effect =
      effect_on_joints(scope, "rotor_inertia", "rotor inertia beyond the stated one at");
  effect.parameters = {{"inertia", "kg m^2", 0.0, {0.0, 6.0 * scale}, scale}};
  effect.apply = [select = scope.select](const Vector& theta, Plant& plant) {
    PlanarModel& model = plant.model;
    for (const std::string& joint : select(model).joints)
      model.motors[model.motor_index(joint)].rotor_inertia += theta[0];
  };

  effect.overrides = [select = scope.select](const Vector& theta, const PlanarModel& model) {
    Overrides values;
    for (const std::string& joint : select(model).joints) {
      const PlanarMotor& motor = model.motors[model.motor_index(joint)];
      if (motor.ideal()) continue;  // has no such key
      values.emplace_back("motors." + joint + ".rotor_inertia",
                          text_of(motor.rotor_inertia + theta[0]));
    }
    return values;
  };

  return effect;
}

Effect link_inertia(const JointScope& scope) {
  Effect effect = on_links(scope, "inertia", "moment of inertia about the centre of mass",
                           [](const Vector& theta, PlanarBody& link) { link.inertia *= theta[0]; });
  effect.parameters = {{"scale", "-", 1.0, {0.1, 6.0}, 0.4}};
  return effect;
}

Effect link_mass(const JointScope& scope) {
  Effect effect = on_links(scope, "mass", "mass, with inertia in proportion,",
                           [](const Vector& theta, PlanarBody& link) {
                             link.mass *= theta[0];
                             link.inertia *= theta[0];
                           });
  effect.parameters = {{"scale", "-", 1.0, {0.2, 3.0}, 0.2}};
  return effect;
}

// Of the base's mass and half length, what others commonly mount or move.
constexpr double kUsualPayload = 1.0 / 12.0, kMostPayload = 0.5;
constexpr double kMovedMass = 0.1;  // carried from the middle to the end

Effect payload(const BaseSize& base) {
  Effect effect = effect_on_base("payload", "a mass on the base that the model does not have",
                                 [](const Vector& theta, PlanarBody& base) {
                                   add_mass(base, theta[0], {theta[1], theta[2]});
                                 });
  // In both directions of its length: what stands on a base may be higher than it.
  const double half = base.half.x();
  const double x = base.com.x(), z = base.com.y();
  effect.parameters = {
      {"mass", "kg", 0.0, {0.0, kMostPayload * base.mass}, kUsualPayload * base.mass},
      {"x", "m", x, {x - half, x + half}, 0.4 * half},
      {"z", "m", z, {z - 0.7 * half, z + half}, 0.2 * half}};
  return effect;
}

/// By no more than half of a uniform bar that spreads as the base's mass does.
Effect com_shift(const BaseSize& base) {
  Effect effect = effect_on_base("com_shift", "the base's centre of mass lies elsewhere",
                                 [](const Vector& theta, PlanarBody& base) { base.com += theta; });
  const Vec2& half = base.half;
  effect.parameters = {{"x", "m", 0.0, {-half.x(), half.x()}, kMovedMass * half.x()},
                       {"z", "m", 0.0, {-half.y(), half.y()}, kMovedMass * half.y()}};
  return effect;
}

Effect body_inertia() {
  Effect effect =
      effect_on_base("body_inertia", "the base's pitch inertia is other than stated",
                     [](const Vector& theta, PlanarBody& base) { base.inertia *= theta[0]; });
  effect.parameters = {{"scale", "-", 1.0, {0.2, 3.0}, 0.25}};
  return effect;
}

/// A base that is held nose-down by an angle, or a bench that slopes along x: in its frame gravity
/// is g (sin, -cos). Of a base that moves, motion capture shows the tilt and the floor takes part.
Effect base_tilt() {
  Effect effect;
  effect.name = "base_tilt";
  effect.caption = "the base is held aslant, so that gravity leans along x";
  effect.where = {Component::body};
  effect.excited_by = {ExperimentKind::tail_bench, ExperimentKind::pendulum};
  effect.parameters = {{"angle", "rad", 0.0, {-0.3, 0.3}, 0.03}};
  effect.applies = [](const PlanarModel& model) {
    return !base_moves(model) && model.gravity > 0.0;
  };
  effect.apply = [](const Vector& theta, Plant& plant) { plant.gravity_tilt += theta[0]; };
  return effect;
}

}  // namespace

std::vector<Row> inertia() {
  const JointScope &tail = tail_scope(), &legs = leg_scope(), &other = other_scope();
  return {
      {rotor_inertia, {tail, legs, other}},
      {link_inertia, {tail, legs, other}},
      {link_mass, {tail, other}},
      {payload},
      {com_shift},
      {body_inertia},
      {base_tilt},
  };
}

}  // namespace jaculus::effects
