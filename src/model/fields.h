#pragma once
// Every number of a PlanarModel that a user may name, in one table: robot.yaml is read by it,
// overrides are applied by it and `jaculus check` lists it.

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "jaculus/core/units.h"
#include "jaculus/core/yaml.h"
#include "jaculus/model/planar.h"

namespace jaculus::model {

/// One value of a model. The pointer lives as long as the model that it was made from stands where
/// it is.
struct Field {
  std::string path;   ///< "motors.tail.resistance"
  std::string alias;  ///< a shorter path, "tail.mass"; may be empty
  std::variant<double*, Vec2*, Bounds*, DragKind*> target;
  Dimension dimension;
  Bounds allowed;         ///< of a number
  bool required = false;  ///< robot.yaml must give it
  bool limit = false;     ///< may be .inf: none

  /// The last part of its path, which is its key in robot.yaml.
  [[nodiscard]] std::string key() const { return path.substr(path.rfind('.') + 1); }
  /// Sets the value from a node: InputError where it is of the wrong kind, unit or range.
  void read(const yaml::Node& node) const;
  /// Its value as a user would write it, "2 [-]".
  [[nodiscard]] std::string shown() const;
};

/// A key of a motor or of a drag section and the member that it fills, declared once: robot.yaml is
/// read by it, override paths end with it, `jaculus check --explain` prints it.
template <class S>
struct Key {
  std::string_view name;
  std::variant<double S::*, Vec2 S::*, DragKind S::*> member;
  Dimension dimension;
  Bounds allowed;  ///< of a number
  std::string_view meaning;
  bool required = false;
};
/// An ideal motor has those of ideal_motor_keys(), forces where its joint slides.
const std::vector<Key<PlanarMotor>>& motor_keys();
const std::vector<std::string_view>& ideal_motor_keys();
const std::vector<Key<PlanarDrag>>& drag_keys();

std::vector<Field> motor_fields(PlanarMotor& motor, bool prismatic);
std::vector<Field> drag_fields(PlanarDrag& drag);

/// All of them.
std::vector<Field> model_fields(PlanarModel& model);

/// The names of DragKind, as written in YAML.
const std::vector<std::string>& drag_kinds();

/// A path and the value to set there.
struct OverrideInput {
  std::string path;
  yaml::Node value;
};

/// Whether `path` is what an override's path names; "*" there stands for any one part between dots.
bool matches(std::string_view pattern, std::string_view path);

/// Applies overrides ("*" stands for any one part of a path; a path in full wins over one with "*";
/// "=path" copies another value). Unknown path, one value set twice, a cycle: InputError.
void apply_overrides(PlanarModel& model, const std::vector<OverrideInput>& overrides);

}  // namespace jaculus::model
