#pragma once
// Every number of a PlanarModel that a user may name, in one table: robot.yaml is read by it, overrides are applied by it and
// `jaculus check` lists it.

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "jaculus/core/units.h"
#include "jaculus/core/yaml.h"
#include "jaculus/model/planar.h"

namespace jaculus {

/// One value of a model. The pointer lives as long as the model that it was made from stands where it is.
struct Field {
  std::string path;   ///< "motors.tail.resistance"
  std::string alias;  ///< a shorter path, "tail.mass"; may be empty
  std::variant<double*, Vec2*, Bounds*, DragKind*> target;
  Dimension dimension;
  Bounds allowed;  ///< of a number

  /// Sets the value from a node: InputError where it is of the wrong kind, unit or range.
  void read(const yaml::Node& node) const;
  /// Its value as a user would write it, "2 [-]".
  [[nodiscard]] std::string shown() const;
};

/// What every key of a motor or a drag section means; the same keys stand in robot.yaml and in override paths.
struct Key {
  std::string_view name;
  std::string_view unit;
  std::string_view meaning;
};
const std::vector<Key>& motor_keys();
const std::vector<Key>& drag_keys();

std::vector<Field> motor_fields(PlanarMotor& motor, bool prismatic);
std::vector<Field> drag_fields(PlanarDrag& drag);

/// All of them.
std::vector<Field> model_fields(PlanarModel& model);

/// The names of DragKind, as written in YAML.
const std::vector<std::string>& drag_kinds();

/// Applies overrides ("*" stands for any one part of a path; a path in full wins over one with "*"; "=path" copies another
/// value). Unknown path, one value set twice, a cycle: InputError.
struct OverrideInput {
  std::string path;
  yaml::Node value;
};
void apply_overrides(PlanarModel& model, const std::vector<OverrideInput>& overrides);

}  // namespace jaculus
