#pragma once
// An effect as somebody would add it: its function and its row, known to no other file.

#include "effects/families.h"

namespace jaculus::test {

/// A share of a motor's torque that never arrives at its joint, as behind a clutch that slips.
inline effects::Effect lost_torque(const effects::JointScope& scope) {
  effects::Effect effect =
      effects::effect_on_joints(scope, "lost_torque", "part of the motor's torque is lost before");
  effect.parameters = {{"share", "-", 0.0, {0.0, 0.9}, 0.1}};

  effect.apply = [select = scope.select](const Vector& theta, simulation::Plant& plant) {
    for (const std::string& joint : select(plant.model).joints) {
      double& scale = plant.actuation.torque_scale.try_emplace(joint, 1.0).first->second;
      scale *= 1.0 - theta[0];
    }
  };
  return effect;
}

inline std::vector<effects::Row> own_rows() {
  return {
      {lost_torque, {effects::other_scope()}},
  };
}

/// The library's effects and this one.
inline const std::vector<effects::Effect>& catalogue_with_own_effect() {
  static const std::vector<effects::Effect> catalogue = [] {
    std::vector<effects::Effect> all = effects::effect_catalogue();
    for (const effects::Effect& own : effects::effects_of(own_rows())) all.push_back(own);
    return all;
  }();
  return catalogue;
}

}  // namespace jaculus::test
