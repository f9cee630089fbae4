#pragma once
// Effects whose forces a program computes in place of a file's formulas. All that is declared
// stands in a node with the keys of an effect's file (user_effect.h): format, name, caption, at,
// component, parameters, and states with unit, initial and scale. Python's effects are these.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/effects/user_effect.h"
#include "jaculus/simulation/law.h"

namespace jaculus::effects {

struct EffectCode {
  std::vector<std::string> reads;  ///< as formulas name them: "qd", "elbow.q"
  /// Keys of an effect's file that say what it does: "torque", "force"; not delay, not reading.
  std::vector<std::string> actions;
  /// Of a law at `theta`, new ones for each run: readings, actions and states in the order of
  /// `reads`, `actions` and the node. Values follow from these alone, or runs differ.
  std::function<simulation::LawFunctions(const Vector& theta)> functions;
};

/// InputError as of read_user_effect; units are not checked, all is in SI.
UserEffect coded_effect(const yaml::Node& node, const EffectCode& code);

}  // namespace jaculus::effects
