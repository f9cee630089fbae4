// What sensors make of the motion.

#include "effects/families.h"

namespace jaculus::effects {
namespace {

Effect on_sensing(const std::string& name, const std::string& caption) {
  Effect effect;
  effect.name = name;
  effect.caption = caption;
  effect.where = Component::sensing;
  effect.excited_by = {"leap", "self_righting", "tail_bench", "pendulum"};
  return effect;
}

void add_to(std::map<std::string, double>& values, const std::string& key, double sum) {
  values.try_emplace(key, 0.0).first->second += sum;
}

void scale_by(std::map<std::string, double>& values, const std::string& key, double factor) {
  values.try_emplace(key, 1.0).first->second *= factor;
}

}  // namespace

Effect joint_offset(const Group& group) {
  const bool legs = &group == &leg_group();
  Effect effect = on_sensing(legs ? "leg_offset" : group.prefix + "_offset",
                             "encoders read other angles than those of " + group.caption);
  effect.excited_by = group.excited_by;
  const std::string unit = "rad";
  effect.applies = has_joints(group);
  if (!legs) {
    effect.parameters = {{"offset", unit, 0.0, {-0.2, 0.2}, 0.03, "", "", "", kNaN}};
    effect.apply = [&group](const Vector& theta, Plant& plant) {
      for (const std::string& joint : joints_of(group, plant.model)) add_to(plant.sensing.offset, joint, theta[0]);
    };
    return effect;
  }
  // One for the front and one for the rear legs: both motors of a leg alike, so that it reads longer or shorter than it is.
  effect.parameters = {{"front", unit, 0.0, {-0.2, 0.2}, 0.03, "", "", "", kNaN},
                       {"rear", unit, 0.0, {-0.2, 0.2}, 0.03, "", "", "", kNaN}};
  effect.apply = [](const Vector& theta, Plant& plant) {
    const JointGroups groups = joint_groups(plant.model);
    for (const std::string& joint : groups.front) add_to(plant.sensing.offset, joint, theta[0]);
    for (const std::string& joint : groups.rear) add_to(plant.sensing.offset, joint, theta[1]);
  };
  return effect;
}

Effect sensor_latency() {
  Effect effect = on_sensing("sensor_latency", "every sensor stamps its samples late");
  effect.also = {Component::actuation};
  effect.parameters = {{"latency", "s", 0.0, {0.0, 0.05}, 0.008, "", "", "", 0.002}};
  effect.applies = [](const PlanarModel&) { return true; };
  effect.apply = [](const Vector& theta, Plant& plant) {
    for (const std::string stream : {"mocap", "joints"}) add_to(plant.sensing.latency, stream, theta[0]);
  };
  return effect;
}

Effect mocap_scale() {
  Effect effect = on_sensing("sensor_scale", "motion capture reads lengths too large or too small");
  effect.excited_by = {"leap"};
  effect.parameters = {{"scale", "-", 1.0, {0.8, 1.2}, 0.03, "", "", "", kNaN}};
  effect.applies = [](const PlanarModel& model) { return model.base_free[0] || model.base_free[1]; };
  effect.apply = [](const Vector& theta, Plant& plant) {
    for (const std::string channel : {"x", "z"}) scale_by(plant.sensing.scale, channel, theta[0]);
  };
  return effect;
}

Effect joint_scale(const Group& group) {
  Effect effect = on_sensing(group.prefix + "_sensor_scale",
                             "encoders read angles of " + group.caption + " too large or too small");
  effect.excited_by = group.excited_by;
  effect.parameters = {{"scale", "-", 1.0, {0.8, 1.2}, 0.03, "", "", "", kNaN}};
  effect.applies = has_joints(group);
  effect.apply = [&group](const Vector& theta, Plant& plant) {
    for (const std::string& joint : joints_of(group, plant.model)) {
      scale_by(plant.sensing.scale, joint, theta[0]);
      scale_by(plant.sensing.scale, joint + "_velocity", theta[0]);
    }
  };
  return effect;
}

}  // namespace jaculus::effects
