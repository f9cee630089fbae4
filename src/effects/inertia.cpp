// Masses where the model does not have them.

#include "effects/families.h"

namespace jaculus::effects {
namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

std::vector<ModelOverride> body_values(const PlanarBody& body) {
  return {{"bodies." + body.name + ".mass", text_of(body.mass)},
          {"bodies." + body.name + ".com", text_of(body.com)},
          {"bodies." + body.name + ".inertia", text_of(body.inertia)}};
}

Effect on_base(const std::string& name, const std::string& caption) {
  Effect effect;
  effect.name = name;
  effect.caption = caption;
  effect.where = Component::body;
  effect.excited_by = {"leap", "self_righting"};
  effect.applies = [](const PlanarModel& model) { return base_moves(model) && model.bodies.front().mass > 0.0; };
  return effect;
}

/// Apply and overrides of an effect that edits the base: the same edit for both.
void edits_base(Effect& effect, std::function<void(const Vector&, PlanarBody&)> edit) {
  effect.apply = [edit](const Vector& theta, Plant& plant) { edit(theta, plant.model.bodies.front()); };
  effect.overrides = [edit](const Vector& theta, const PlanarModel& model) {
    PlanarBody base = model.bodies.front();
    edit(theta, base);
    return body_values(base);
  };
}

/// A point mass at `place` in the body's frame [m].
void add_mass(PlanarBody& body, double mass, const Vec2& place) {
  if (mass == 0.0) return;
  const double total = body.mass + mass;
  body.inertia += body.mass * mass / total * (place - body.com).squaredNorm();
  body.com = (body.mass * body.com + mass * place) / total;
  body.mass = total;
}

/// The same for every link beyond a group's joints.
void edits_links(Effect& effect, const Group& group, std::function<void(const Vector&, PlanarBody&)> edit) {
  effect.apply = [edit, &group](const Vector& theta, Plant& plant) {
    for (const int b : bodies_of(group, plant.model)) edit(theta, plant.model.bodies[at(b)]);
  };
  effect.overrides = [edit, &group](const Vector& theta, const PlanarModel& model) {
    std::vector<ModelOverride> values;
    for (const int b : bodies_of(group, model)) {
      PlanarBody link = model.bodies[at(b)];
      edit(theta, link);
      for (const ModelOverride& value : body_values(link)) values.push_back(value);
    }
    return values;
  };
}

/// Links are bodies of the robot, whoever's joint carries them; a pendulum's are its body.
Effect on_links(const Group& group, const std::string& kind, const std::string& caption) {
  Effect effect;
  effect.name = group.link_prefix + "_" + kind;
  effect.caption = caption + " of every link beyond " + group.caption + " is other than stated";
  effect.where = &group == &other_group() ? Component::body : group.where;
  effect.also = group.also;
  if (effect.where != Component::body) effect.also.push_back(Component::body);
  effect.excited_by = group.excited_by;
  effect.applies = has_joints(group);
  return effect;
}

}  // namespace

Effect rotor_inertia(const Group& group) {
  Effect effect;
  effect.name = group.prefix + "_rotor_inertia";
  effect.caption = "rotor inertia beyond the stated one at " + group.caption;
  effect.where = group.where;
  effect.also = group.also;
  effect.excited_by = group.excited_by;
  effect.parameters = {{"inertia", "kg m^2", 0.0, {0.0, 6.0 * group.inertia}, group.inertia, "", "", "", kNaN}};
  effect.applies = has_joints(group);
  effect.apply = [&group](const Vector& theta, Plant& plant) {
    for (const std::string& joint : joints_of(group, plant.model)) {
      plant.model.motors[at(plant.model.motor_index(joint))].rotor_inertia += theta[0];
    }
  };
  effect.overrides = [&group](const Vector& theta, const PlanarModel& model) {
    std::vector<ModelOverride> values;
    for (const std::string& joint : joints_of(group, model)) {
      const PlanarMotor& motor = model.motors[at(model.motor_index(joint))];
      if (motor.ideal()) continue;  // has no such key
      values.emplace_back("motors." + joint + ".rotor_inertia", text_of(motor.rotor_inertia + theta[0]));
    }
    return values;
  };
  return effect;
}

Effect link_inertia(const Group& group) {
  Effect effect = on_links(group, "inertia", "moment of inertia about the centre of mass");
  effect.parameters = {{"scale", "-", 1.0, {0.1, 6.0}, 0.4, "", "", "", kNaN}};
  edits_links(effect, group, [](const Vector& theta, PlanarBody& link) { link.inertia *= theta[0]; });
  return effect;
}

Effect link_mass(const Group& group) {
  Effect effect = on_links(group, "mass", "mass, with inertia in proportion,");
  effect.parameters = {{"scale", "-", 1.0, {0.2, 3.0}, 0.2, "", "", "", kNaN}};
  edits_links(effect, group, [](const Vector& theta, PlanarBody& link) {
    link.mass *= theta[0];
    link.inertia *= theta[0];
  });
  return effect;
}

Effect payload() {
  Effect effect = on_base("payload", "a mass on the base that the model does not have");
  effect.parameters = {{"mass", "kg", 0.0, {0.0, 3.0}, 0.5, "", "", "", kNaN},
                       {"x", "m", 0.0, {-0.3, 0.3}, 0.12, "", "", "", kNaN},
                       {"z", "m", 0.0, {-0.2, 0.3}, 0.06, "", "", "", kNaN}};
  edits_base(effect, [](const Vector& theta, PlanarBody& base) { add_mass(base, theta[0], {theta[1], theta[2]}); });
  return effect;
}

Effect com_shift() {
  Effect effect = on_base("com_shift", "the base's centre of mass lies elsewhere");
  effect.parameters = {{"x", "m", 0.0, {-0.1, 0.1}, 0.02, "", "", "", kNaN},
                       {"z", "m", 0.0, {-0.08, 0.08}, 0.02, "", "", "", kNaN}};
  edits_base(effect, [](const Vector& theta, PlanarBody& base) { base.com += theta; });
  return effect;
}

Effect body_inertia() {
  Effect effect = on_base("body_inertia", "the base's pitch inertia is other than stated");
  effect.parameters = {{"scale", "-", 1.0, {0.2, 3.0}, 0.25, "", "", "", kNaN}};
  edits_base(effect, [](const Vector& theta, PlanarBody& base) { base.inertia *= theta[0]; });
  return effect;
}

}  // namespace jaculus::effects
