// The air about the tail.

#include "effects/families.h"

namespace jaculus::effects {
namespace {

using model::DragKind;

bool has_drag(const PlanarModel& model) {
  return std::any_of(model.drags.begin(), model.drags.end(), [](const PlanarDrag& drag) {
    return drag.kind != DragKind::none && drag.coefficient > 0.0;
  });
}

Effect on_drag(const std::string& name, const std::string& caption) {
  Effect effect;
  effect.name = name;
  effect.caption = caption;
  effect.where = {Component::tail_aerodynamics};
  effect.excited_by = {ExperimentKind::leap, ExperimentKind::self_righting,
                       ExperimentKind::tail_bench};
  effect.applies = has_drag;
  return effect;
}

Effect drag_coefficient() {
  Effect effect = on_drag("drag_coefficient", "the tail's drag coefficient is other than stated");
  effect.parameters = {{"scale", "-", 1.0, {0.0, 3.0}, 0.25}};
  effect.apply = [](const Vector& theta, Plant& plant) {
    for (PlanarDrag& drag : plant.model.drags) drag.coefficient *= theta[0];
  };
  effect.overrides = [](const Vector& theta, const PlanarModel& model) {
    std::vector<ModelOverride> values;
    for (const PlanarDrag& drag : model.drags)
      values.emplace_back(drag.name + ".drag.coefficient", text_of(drag.coefficient * theta[0]));
    return values;
  };
  return effect;
}

/// A share b of the strip feels its rotation alone: two entries, of coefficients (1 - b) C_D and
/// b C_D.
Effect drag_without_translation() {
  Effect effect =
      on_drag("drag_without_translation", "drag that the body's motion through the air leaves out");
  effect.excited_by = {ExperimentKind::leap, ExperimentKind::self_righting};
  effect.parameters = {{"share", "-", 0.0, {0.0, 1.0}, 0.5, 1.0}};
  effect.applies = [](const PlanarModel& model) {
    const auto strip = [](const PlanarDrag& drag) {
      return drag.kind == DragKind::distributed && drag.coefficient > 0.0;
    };
    return base_moves(model) && std::any_of(model.drags.begin(), model.drags.end(), strip);
  };
  effect.apply = [](const Vector& theta, Plant& plant) {
    if (theta[0] == 0.0) return;

    std::vector<PlanarDrag> rotating;
    for (PlanarDrag& drag : plant.model.drags) {
      if (drag.kind != DragKind::distributed) continue;
      rotating.push_back(drag);
      rotating.back().kind = DragKind::rotation;
      rotating.back().coefficient = drag.coefficient * theta[0];
      drag.coefficient *= 1.0 - theta[0];
    }
    plant.model.drags.insert(plant.model.drags.end(), rotating.begin(), rotating.end());
  };
  return effect;
}

Effect wind() {
  Effect effect = on_drag("wind", "the air moves along x");
  effect.parameters = {{"speed", "m/s", 0.0, {-5.0, 5.0}, 0.7}};
  effect.apply = [](const Vector& theta, Plant& plant) {
    for (PlanarDrag& drag : plant.model.drags) drag.wind_W.x() += theta[0];
  };
  effect.overrides = [](const Vector& theta, const PlanarModel& model) {
    std::vector<ModelOverride> values;
    for (const PlanarDrag& drag : model.drags) {
      const Vec2 wind_W = drag.wind_W + Vec2(theta[0], 0.0);
      values.emplace_back(drag.name + ".drag.wind", text_of(wind_W));
    }
    return values;
  };
  return effect;
}

}  // namespace

std::vector<Row> aerodynamics() { return {drag_coefficient, drag_without_translation, wind}; }

}  // namespace jaculus::effects
