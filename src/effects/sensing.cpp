// What sensors make of the motion.

#include "effects/families.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::effects {
namespace {

using trajectory::Quantity;

void add_to(std::map<std::string, double>& values, const std::string& key, double sum) {
  values.try_emplace(key, 0.0).first->second += sum;
}

void scale_by(std::map<std::string, double>& values, const std::string& key, double factor) {
  values.try_emplace(key, 1.0).first->second *= factor;
}

/// Encoders are sensors, wherever their joints are.
Effect on_encoders(const JointScope& scope, const std::string& kind, const std::string& caption) {
  Effect effect = effect_on_joints(scope, kind, "");
  effect.caption = caption;
  effect.where = {Component::sensing};
  return effect;
}

/// Motion capture sees a base that moves.
Effect on_motion_capture(const std::string& name, const std::string& caption) {
  Effect effect;
  effect.name = name;
  effect.caption = caption;
  effect.where = {Component::sensing};
  effect.excited_by = {ExperimentKind::leap};
  return effect;
}

/// One offset for all joints of a scope, or one for each part: both motors of a leg alike, so that
/// it reads longer or shorter than it is.
Effect joint_offset(const JointScope& scope) {
  Effect effect =
      on_encoders(scope, "offset", "encoders read other angles than those of " + scope.caption);
  std::vector<JointScope> parts = scope.parts;
  if (parts.empty()) parts = {scope};
  for (const JointScope& part : parts) {
    const std::string name = scope.parts.empty() ? "offset" : part.side;
    effect.parameters.push_back({name, "rad", 0.0, {-0.2, 0.2}, 0.03});
  }

  effect.apply = [parts](const Vector& theta, Plant& plant) {
    for (std::size_t k = 0; k < parts.size(); ++k)
      for (const std::string& joint : parts[k].select(plant.model).joints)
        add_to(plant.sensing.offset, joint, theta[k]);
  };
  return effect;
}

Effect joint_scale(const JointScope& scope) {
  Effect effect =
      on_encoders(scope, "sensor_scale",
                  "encoders read angles of " + scope.caption + " too large or too small");
  effect.parameters = {{"scale", "-", 1.0, {0.8, 1.2}, 0.03}};
  effect.apply = [select = scope.select](const Vector& theta, Plant& plant) {
    for (const std::string& joint : select(plant.model).joints) {
      scale_by(plant.sensing.scale, joint, theta[0]);
      scale_by(plant.sensing.scale, channel_name(joint, Quantity::velocity), theta[0]);
    }
  };
  return effect;
}

Effect sensor_latency() {
  Effect effect;
  effect.name = "sensor_latency";
  effect.caption = "every sensor stamps its samples late";
  effect.where = {Component::sensing, Component::actuation};
  effect.excited_by = {ExperimentKind::leap, ExperimentKind::self_righting,
                       ExperimentKind::tail_bench, ExperimentKind::pendulum};
  effect.parameters = {{"latency", "s", 0.0, {0.0, 0.05}, 0.008, 0.002}};
  effect.applies = [](const PlanarModel&) { return true; };
  effect.apply = [](const Vector& theta, Plant& plant) {
    for (const std::string stream : {trajectory::kMocapStream, trajectory::kJointStream})
      add_to(plant.sensing.latency, stream, theta[0]);
  };
  return effect;
}

Effect mocap_scale() {
  Effect effect =
      on_motion_capture("sensor_scale", "motion capture reads lengths too large or too small");
  effect.parameters = {{"scale", "-", 1.0, {0.8, 1.2}, 0.03}};
  effect.applies = [](const PlanarModel& model) {
    return model.base_free[0] || model.base_free[1];
  };
  effect.apply = [](const Vector& theta, Plant& plant) {
    for (const std::string channel : {"x", "z"}) scale_by(plant.sensing.scale, channel, theta[0]);
  };
  return effect;
}

bool base_travels(const PlanarModel& model) { return model.base_free[0] && model.base_free[1]; }

/// Markers' middle is seldom the base's origin: where the base pitches, their x and z move by it.
Effect tracked_point() {
  Effect effect =
      on_motion_capture("tracked_point", "motion capture tracks another point of the base");
  effect.parameters = {{"x", "m", 0.0, {-0.2, 0.2}, 0.03}, {"z", "m", 0.0, {-0.1, 0.1}, 0.015}};
  effect.applies = [](const PlanarModel& model) {
    return base_travels(model) && model.base_free[2];
  };
  effect.apply = [](const Vector& theta, Plant& plant) { plant.sensing.tracked_point += theta; };
  return effect;
}

/// A ground plane that was set aslant: what moves along x seems to rise or to sink.
Effect mocap_tilt() {
  Effect effect = on_motion_capture("mocap_tilt", "motion capture's axes are tilted in the plane");
  effect.parameters = {{"angle", "rad", 0.0, {-0.1, 0.1}, 0.01}};
  effect.applies = [](const PlanarModel& model) { return base_travels(model); };
  effect.apply = [](const Vector& theta, Plant& plant) { plant.sensing.mocap_tilt += theta[0]; };
  return effect;
}

}  // namespace

std::vector<Row> sensing() {
  const JointScope &tail = tail_scope(), &legs = leg_scope(), &other = other_scope();
  return {
      {joint_offset, {tail, legs, other}},
      {sensor_latency},
      {mocap_scale},
      {tracked_point},
      {mocap_tilt},
      {joint_scale, {other}},
  };
}

}  // namespace jaculus::effects
