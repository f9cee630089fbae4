// Between a motor and its link: flexing shafts, play, friction, stops.

#include <algorithm>

#include "effects/families.h"

namespace jaculus::effects {
namespace {

/// The plant's entry for a joint, made where there is none.
template <class Entry>
Entry& entry_of(std::vector<Entry>& entries, const std::string& joint) {
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.joint == joint; });
  if (found != entries.end()) return *found;
  entries.push_back({});
  entries.back().joint = joint;
  return entries.back();
}

/// An effect on every joint of a group.
Effect on_group(const Group& group, const std::string& kind, const std::string& caption) {
  Effect effect;
  effect.name = group.prefix + "_" + kind;
  effect.caption = caption + " " + group.caption;
  effect.where = group.where;
  effect.also = group.also;
  effect.excited_by = group.excited_by;
  effect.applies = has_joints(group);
  return effect;
}

std::function<void(const Vector&, Plant&)> on_friction(const Group& group,
                                                       std::function<void(const Vector&, JointFriction&)> set) {
  return [&group, set](const Vector& theta, Plant& plant) {
    for (const std::string& joint : joints_of(group, plant.model)) set(theta, entry_of(plant.friction, joint));
  };
}

/// Shafts flex and gears play where there is a gear or nobody says that there is none.
bool may_have_gear(const Group& group, const PlanarModel& model) {
  const std::vector<std::string> joints = joints_of(group, model);
  return std::any_of(joints.begin(), joints.end(), [&](const std::string& joint) {
    const PlanarMotor& motor = model.motors[static_cast<std::size_t>(model.motor_index(joint))];
    return motor.ideal() || motor.gear != 1.0;
  });
}

/// Damping ratio of the link on a flank alone: teeth hit one another without much rebound, how much nobody knows.
constexpr double kFlankDamping = 0.7;

}  // namespace

Effect compliance(const Group& group) {
  Effect effect = on_group(group, "compliance", "torsional spring and damper at the root of");
  effect.parameters = {{"compliance", "rad/(N m)", 0.0, {0.0, 0.05}, 0.01, "reciprocal", "stiffness", "N m/rad", kNaN},
                       {"damping_ratio", "-", 0.05, {0.0, 1.0}, 0.1, "", "", "", kNaN}};
  effect.apply = [&group](const Vector& theta, Plant& plant) {
    if (theta[0] == 0.0) return;
    for (const std::string& joint : joints_of(group, plant.model)) {
      Transmission& transmission = entry_of(plant.transmissions, joint);
      transmission.compliance = theta[0];
      transmission.damping_ratio = theta[1];
    }
  };
  return effect;
}

Effect backlash(const Group& group) {
  Effect effect = on_group(group, "backlash", "play in the gear of");
  effect.parameters = {{"play", "rad", 0.0, {0.0, 0.06}, 0.01, "", "", "", kNaN},
                       {"flank_damping_ratio", "-", kFlankDamping, {0.1, 1.0}, 0.3, "", "", "", kNaN}};
  effect.applies = [&group](const PlanarModel& model) { return may_have_gear(group, model); };
  effect.apply = [&group](const Vector& theta, Plant& plant) {
    if (theta[0] == 0.0) return;
    for (const std::string& joint : joints_of(group, plant.model)) {
      Transmission& transmission = entry_of(plant.transmissions, joint);
      transmission.play = theta[0];
      if (transmission.compliance == 0.0) transmission.damping_ratio = theta[1];
    }
  };
  return effect;
}

Effect coulomb_friction(const Group& group) {
  Effect effect = on_group(group, "coulomb_friction", "dry friction at");
  effect.parameters = {{"torque", "N m", 0.0, {0.0, 10.0 * group.torque}, group.torque, "", "", "", kNaN}};
  effect.apply = on_friction(group, [](const Vector& theta, JointFriction& friction) { friction.coulomb = theta[0]; });
  return effect;
}

Effect viscous_friction(const Group& group) {
  const double scale = group.torque / group.rate;
  Effect effect = on_group(group, "viscous_friction", "friction in proportion to speed at");
  effect.parameters = {{"coefficient", "N m s/rad", 0.0, {0.0, 10.0 * scale}, scale, "", "", "", kNaN}};
  effect.apply = on_friction(group, [](const Vector& theta, JointFriction& friction) { friction.viscous = theta[0]; });
  return effect;
}

Effect stribeck_friction(const Group& group) {
  Effect effect = on_group(group, "stribeck_friction", "stiction that fades with speed at");
  effect.parameters = {{"torque", "N m", 0.0, {0.0, 40.0 * group.torque}, 4.0 * group.torque, "", "", "", kNaN},
                       {"rate", "rad/s", 2.0, {0.2, 20.0}, 2.0, "", "", "", kNaN}};
  effect.apply = on_friction(group, [](const Vector& theta, JointFriction& friction) {
    if (theta[0] == 0.0) return;
    friction.stribeck = theta[0];
    friction.stribeck_rate = theta[1];
  });
  return effect;
}

Effect load_friction(const Group& group) {
  Effect effect = on_group(group, "load_friction", "friction in proportion to the motor's torque at");
  effect.parameters = {{"share", "-", 0.0, {0.0, 0.6}, 0.1, "", "", "", kNaN}};
  effect.apply = on_friction(group, [](const Vector& theta, JointFriction& friction) { friction.load = theta[0]; });
  return effect;
}

Effect stop_restitution() {
  Effect effect;
  effect.name = "tail_stop_restitution";
  effect.caption = "the tail bounces off its stop";
  effect.where = Component::tail_transmission;
  effect.excited_by = {"self_righting"};
  effect.parameters = {{"restitution", "-", 0.0, {0.0, 0.95}, 0.25, "", "", "", kNaN}};
  const auto stopped = [](const PlanarModel& model, const std::string& joint) {
    const int c = model.coordinate_index(joint);
    if (c < 0) return false;
    const Bounds range = model.coordinates[static_cast<std::size_t>(c)].range;
    return range.lower > -kInfinity || range.upper < kInfinity;
  };
  effect.applies = [stopped](const PlanarModel& model) {
    const std::vector<std::string> tail = joint_groups(model).tail;
    return std::any_of(tail.begin(), tail.end(), [&](const std::string& joint) { return stopped(model, joint); });
  };
  effect.apply = [](const Vector& theta, Plant& plant) {
    const std::vector<std::string> tail = joint_groups(plant.model).tail;
    for (JointStop& stop : plant.stops) {
      if (std::find(tail.begin(), tail.end(), stop.joint) != tail.end()) stop.restitution = theta[0];
    }
  };
  return effect;
}

}  // namespace jaculus::effects
