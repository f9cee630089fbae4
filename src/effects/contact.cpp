// Between feet and floor.

#include "effects/families.h"

namespace jaculus::effects {
namespace {

bool has_feet(const PlanarModel& model) { return base_moves(model) && !model.feet.empty(); }

Effect on_feet(const std::string& name, const std::string& caption) {
  Effect effect;
  effect.name = name;
  effect.caption = caption;
  effect.where = {Component::contact};
  effect.excited_by = {ExperimentKind::leap};
  effect.applies = has_feet;
  return effect;
}

Effect foot_friction() {
  Effect effect = on_feet("foot_friction", "friction between feet and floor is other than stated");
  effect.parameters = {{"scale", "-", 1.0, {0.1, 2.0}, 0.25, -0.8}};
  effect.applies = [](const PlanarModel& model) { return has_feet(model) && model.friction > 0.0; };
  effect.apply = [](const Vector& theta, Plant& plant) {
    plant.model.friction *= theta[0];
    plant.ground.friction *= theta[0];
  };
  effect.overrides = [](const Vector& theta, const PlanarModel& model) {
    return std::vector<ModelOverride>{{"friction", text_of(model.friction * theta[0])}};
  };
  return effect;
}

Effect ground_compliance() {
  Effect effect = on_feet("ground_compliance", "a floor or feet that give way");
  effect.parameters = {{.name = "compliance",
                        .unit = "m/N",
                        .bounds = {0.0, 5e-4},
                        .scale = 1e-4,
                        .reciprocal = {{"stiffness", "N/m"}}},
                       {"damping_ratio", "-", 0.3, {0.0, 3.0}, 0.5}};
  effect.apply = [](const Vector& theta, Plant& plant) {
    if (theta[0] == 0.0) return;

    plant.ground.compliance = theta[0];
    plant.ground.damping_ratio = theta[1];
  };
  return effect;
}

Effect foot_radius() {
  Effect effect = on_feet("foot_radius", "feet roll on a round toe");
  effect.parameters = {{"radius", "m", 0.0, {0.0, 0.03}, 0.01}};
  effect.apply = [](const Vector& theta, Plant& plant) { plant.ground.foot_radius += theta[0]; };
  return effect;
}

}  // namespace

std::vector<Row> contact() { return {foot_friction, ground_compliance, foot_radius}; }

}  // namespace jaculus::effects
