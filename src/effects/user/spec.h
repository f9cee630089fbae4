#pragma once
// What a file of a user's effect says (user_effect.h has the format), as values.

#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/units.h"
#include "jaculus/core/yaml.h"
#include "jaculus/effects/coded_effect.h"
#include "jaculus/effects/effect.h"

namespace jaculus::effects {

/// A formula with its place in the file and the dimension that its key asks for.
struct Formula {
  std::string text;
  Dimension dimension;
  yaml::Node node;
};

/// Where an effect acts.
enum class PlaceKind { joints, group, body, point, part, sensor };

struct EffectPlace {
  PlaceKind kind = PlaceKind::joints;
  std::vector<std::string> names;  ///< joints; else the one group, body, point, part or channel
  Vec2 point = Vec2::Zero();       ///< in the body's frame [m]
  /// its joints do: a force acts, not a torque; the channel is of metres
  bool slides = false;
  std::vector<std::string> sliding{};  ///< other joints that formulas read and that slide
  yaml::Node node;

  [[nodiscard]] bool at_joints() const {
    return kind == PlaceKind::joints || kind == PlaceKind::group;
  }
  [[nodiscard]] bool on_body() const { return kind == PlaceKind::body || kind == PlaceKind::point; }
  /// Of what a sensor's channel measures.
  [[nodiscard]] Dimension channel_dimension() const;
};

/// A parameter of the effect with the dimension of its unit.
struct SpecParameter {
  EffectParameter own;
  Dimension dimension;
  yaml::Node node;
};
struct SpecConstant {
  std::string name;
  double value = 0.0;  ///< SI
  Dimension dimension;
};
struct SpecState {
  std::string name;
  Dimension dimension;
  double scale = 1.0;  ///< SI
  Formula initial, derivative;
};
struct SpecValue {
  std::string name;
  Formula formula;
};
/// An action at the effect's place; point_force has two formulas, x and z.
struct SpecAction {
  simulation::ActionKind kind = simulation::ActionKind::joint_torque;
  std::vector<Formula> formulas;
};

struct EffectSpec {
  std::string name, caption;
  EffectPlace place;
  std::optional<Component> component;
  std::filesystem::path experiment;  ///< that shows it, for checks; empty where the file has none
  std::vector<SpecParameter> parameters;
  std::vector<SpecConstant> constants;
  std::vector<SpecState> states;
  std::vector<SpecValue> values;  ///< each may use those before it
  std::vector<SpecAction> actions;
  std::optional<Formula> delay;    ///< of the commands, of parameters alone [s]
  std::optional<Formula> reading;  ///< what the sensor's log has
  yaml::Node node;                 ///< all of it
  std::optional<EffectCode> code;  ///< in place of the formulas of actions and derivatives
};

/// Reads a file; InputError where it says what no file may. Formulas are read, their units aren't
/// checked yet.
EffectSpec read_spec(const std::filesystem::path& file);
/// `folder`: from which its experiment is named.
EffectSpec read_spec(const yaml::Node& root, const std::filesystem::path& folder);
/// The same of a program's effect. Its actions have no formulas, its states no derivatives.
EffectSpec read_spec(const yaml::Node& node, const EffectCode& code);

}  // namespace jaculus::effects
