#include "effects/families.h"

#include <fmt/format.h>

namespace jaculus::effects {

std::function<std::vector<std::string>(const PlanarModel&)> joints_of(const JointScope& scope) {
  return [select = scope.select](const PlanarModel& model) { return select(model).joints; };
}

Effect effect_on_joints(const JointScope& scope, const std::string& kind,
                        const std::string& caption) {
  Effect effect;
  effect.name = scope.prefix + "_" + kind;
  effect.caption = caption + " " + scope.caption;
  effect.where = scope.where;
  effect.excited_by = scope.excited_by;
  effect.joints = joints_of(scope);
  effect.applies = [select = scope.select](const PlanarModel& model) {
    return !select(model).joints.empty();
  };
  return effect;
}

bool base_moves(const PlanarModel& model) {
  return model.base_free[0] || model.base_free[1] || model.base_free[2];
}

std::string text_of(double value) { return fmt::format("{}", value); }
std::string text_of(const Vec2& value) { return fmt::format("[{}, {}]", value.x(), value.y()); }

}  // namespace jaculus::effects
