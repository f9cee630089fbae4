// Between a motor and its link: flexing shafts, play, friction, stops.

#include "effects/families.h"

namespace jaculus::effects {
namespace {

using simulation::JointFriction;
using simulation::Transmission;

/// Damping ratio of the link on a flank alone: teeth hit one another without much rebound, how much
/// nobody knows.
constexpr double kFlankDamping = 0.7;

/// The plant's entry for a joint, made where there is none.
template <class Entry>
Entry& entry_of(std::vector<Entry>& entries, const std::string& joint) {
  const auto found = std::find_if(entries.begin(), entries.end(),
                                  [&](const Entry& entry) { return entry.joint == joint; });
  if (found != entries.end()) return *found;

  entries.push_back({});
  entries.back().joint = joint;
  return entries.back();
}

using Apply = std::function<void(const Vector&, Plant&)>;

/// An edit of the friction at every joint of a scope.
Apply on_friction(const JointScope& scope, void (*edit)(const Vector&, JointFriction&)) {
  return [select = scope.select, edit](const Vector& theta, Plant& plant) {
    for (const std::string& joint : select(plant.model).joints)
      edit(theta, entry_of(plant.friction, joint));
  };
}

/// An edit of the transmission at every joint of a scope; none where the first parameter is zero.
Apply on_transmission(const JointScope& scope, void (*edit)(const Vector&, Transmission&)) {
  return [select = scope.select, edit](const Vector& theta, Plant& plant) {
    if (theta[0] == 0.0) return;

    for (const std::string& joint : select(plant.model).joints)
      edit(theta, entry_of(plant.transmissions, joint));
  };
}

/// Shafts flex and gears play where there is a gear or nobody says that there is none.
bool may_have_gear(const JointScope& scope, const PlanarModel& model) {
  const std::vector<std::string> joints = scope.select(model).joints;
  return std::any_of(joints.begin(), joints.end(), [&](const std::string& joint) {
    const PlanarMotor& motor = model.motors[model.motor_index(joint)];
    return motor.ideal() || motor.gear != 1.0;
  });
}

/// Whether a joint has an end of its travel.
bool has_stop(const PlanarModel& model, const std::string& joint) {
  const int c = model.coordinate_index(joint);
  if (c < 0) return false;

  const Bounds range = model.coordinates[c].range;
  return range.lower > -kInfinity || range.upper < kInfinity;
}

Effect compliance(const JointScope& scope) {
  Effect effect =
      effect_on_joints(scope, "compliance", "torsional spring and damper at the root of");
  const double scale = 0.01 / scope.usual.torque_ratio;
  effect.parameters = {{.name = "compliance",
                        .unit = "rad/(N m)",
                        .bounds = {0.0, 5.0 * scale},
                        .scale = scale,
                        .reciprocal = {{"stiffness", "N m/rad"}}},
                       {"damping_ratio", "-", 0.05, {0.0, 1.0}, 0.1}};
  effect.apply = on_transmission(scope, [](const Vector& theta, Transmission& transmission) {
    transmission.compliance = theta[0];
    transmission.damping_ratio = theta[1];
  });
  return effect;
}

Effect backlash(const JointScope& scope) {
  Effect effect = effect_on_joints(scope, "backlash", "play in the gear of");
  effect.parameters = {{"play", "rad", 0.0, {0.0, 0.06}, 0.01},
                       {"flank_damping_ratio", "-", kFlankDamping, {0.1, 1.0}, 0.3}};
  effect.applies = [scope](const PlanarModel& model) { return may_have_gear(scope, model); };
  effect.apply = on_transmission(scope, [](const Vector& theta, Transmission& transmission) {
    transmission.play = theta[0];
    if (transmission.compliance == 0.0) transmission.damping_ratio = theta[1];
  });
  return effect;
}

/// Bounds and prior of a friction that no file states. Nobody knows its order of magnitude, so that
/// ten times the usual one is three deviations of its prior. A prior as narrow as the usual one
/// gives a large friction's place to others: a tail's viscous friction of nine times the usual one
/// cost 39 nats, and tolerances and wind were cheaper.
EffectParameter friction_size(const char* name, const char* unit, double usual) {
  const double most = 10.0 * usual;
  return {name, unit, 0.0, {0.0, most}, most / 3.0, usual};
}

Effect coulomb_friction(const JointScope& scope) {
  Effect effect = effect_on_joints(scope, "coulomb_friction", "dry friction at");
  effect.parameters = {friction_size("torque", "N m", scope.usual.torque)};
  effect.apply = on_friction(
      scope, [](const Vector& theta, JointFriction& friction) { friction.coulomb = theta[0]; });
  return effect;
}

/// Coulomb friction with a level of its own for each direction, T (1 + r) and T (1 - r), as gears
/// and bearings loaded from one side have it. |r| <= 1 keeps it a loss; without r it is
/// coulomb_friction. While the joint moves it is that and a torque offset of -T r, so that robots
/// are often identified with one offset for both (Janot, Vandanjon and Gautier 2014, "A generic
/// instrumental variable approach for industrial robot identification"); at rest it pushes nothing.
Effect directional_friction(const JointScope& scope) {
  Effect effect = effect_on_joints(scope, "directional_friction",
                                   "dry friction, more one way than the other, at");
  effect.special_case = scope.prefix + "_coulomb_friction";
  effect.parameters = {friction_size("torque", "N m", scope.usual.torque),
                       {"asymmetry", "-", 0.0, {-1.0, 1.0}, 0.3}};
  effect.apply = on_friction(scope, [](const Vector& theta, JointFriction& friction) {
    friction.positive = theta[0] * (1.0 + theta[1]);
    friction.negative = theta[0] * (1.0 - theta[1]);
  });
  return effect;
}

Effect viscous_friction(const JointScope& scope) {
  Effect effect = effect_on_joints(scope, "viscous_friction", "friction in proportion to speed at");
  effect.parameters = {
      friction_size("coefficient", "N m s/rad", scope.usual.torque / scope.usual.rate)};
  effect.apply = on_friction(
      scope, [](const Vector& theta, JointFriction& friction) { friction.viscous = theta[0]; });
  effect.overrides = [select = scope.select](const Vector& theta, const PlanarModel& model) {
    std::vector<ModelOverride> values;
    if (theta[0] == 0.0) return values;
    for (const std::string& joint : select(model).joints) {
      const int m = model.motor_index(joint);
      if (m < 0) return std::vector<ModelOverride>{};  // a joint without motor has no such value
      values.emplace_back("motors." + joint + ".viscous_friction",
                          text_of(model.motors[m].viscous_friction + theta[0]));
    }
    return values;
  };
  return effect;
}

Effect stribeck_friction(const JointScope& scope) {
  const double torque = scope.usual.torque, rate = 2.0 * scope.usual.rate_ratio;
  Effect effect = effect_on_joints(scope, "stribeck_friction", "stiction that fades with speed at");
  effect.parameters = {{"torque", "N m", 0.0, {0.0, 40.0 * torque}, 4.0 * torque},
                       {"rate", "rad/s", rate, {0.1 * rate, 10.0 * rate}, rate}};
  effect.apply = on_friction(scope, [](const Vector& theta, JointFriction& friction) {
    if (theta[0] == 0.0) return;

    friction.stribeck = theta[0];
    friction.stribeck_rate = theta[1];
  });
  return effect;
}

Effect load_friction(const JointScope& scope) {
  Effect effect =
      effect_on_joints(scope, "load_friction", "friction in proportion to the motor's torque at");
  effect.parameters = {{"share", "-", 0.0, {0.0, 0.6}, 0.1}};
  effect.apply = on_friction(
      scope, [](const Vector& theta, JointFriction& friction) { friction.load = theta[0]; });
  return effect;
}

/// The part of load friction that fades with speed. Dry, viscous, fading and load friction are M1
/// to M3 of the ladder of Duclusaud et al. 2024, "Extended friction models for the physics
/// simulation of servo actuators"; this is what M4 adds. The load is the motor's torque, as in load
/// friction.
Effect load_stribeck(const JointScope& scope) {
  const double rate = 0.2 * scope.usual.rate;
  Effect effect = effect_on_joints(scope, "load_stribeck_friction",
                                   "stiction in proportion to the motor's torque at");
  effect.parameters = {{"share", "-", 0.0, {0.0, 0.6}, 0.1},
                       {"rate", "rad/s", rate, {0.1 * rate, 10.0 * rate}, rate}};
  effect.apply = on_friction(scope, [](const Vector& theta, JointFriction& friction) {
    if (theta[0] == 0.0) return;

    friction.load_stribeck = theta[0];
    friction.load_stribeck_rate = theta[1];
  });
  return effect;
}

/// Of tails alone: no other joint is driven into a stop by an experiment.
Effect tail_stop_restitution() {
  Effect effect;
  effect.name = "tail_stop_restitution";
  effect.caption = "the tail bounces off its stop";
  effect.where = tail_scope().where;
  effect.excited_by = {ExperimentKind::self_righting};
  effect.parameters = {{"restitution", "-", 0.0, {0.0, 0.95}, 0.25}};
  effect.applies = [](const PlanarModel& model) {
    const std::vector<std::string> tail = joint_groups(model).tail.joints;
    return std::any_of(tail.begin(), tail.end(),
                       [&](const std::string& joint) { return has_stop(model, joint); });
  };

  effect.apply = [](const Vector& theta, Plant& plant) {
    const std::vector<std::string> tail = joint_groups(plant.model).tail.joints;
    for (simulation::JointStop& stop : plant.stops) {
      const bool own = std::find(tail.begin(), tail.end(), stop.joint) != tail.end();
      if (own) stop.restitution = theta[0];
    }
  };

  return effect;
}

}  // namespace

std::vector<Row> transmission() {
  const JointScope &tail = tail_scope(), &legs = leg_scope(), &other = other_scope();
  return {
      {compliance, {tail, other}},
      {backlash, {tail, legs, other}},
      {tail_stop_restitution},
      {coulomb_friction, {tail, legs, other}},
      {directional_friction, {tail, legs, other}},
      {viscous_friction, {tail, legs, other}},
      {stribeck_friction, {tail, legs, other}},
      {load_friction, {tail, legs, other}},
      {load_stribeck, {tail, legs, other}},
  };
}

}  // namespace jaculus::effects
