#pragma once
// Names of effects as truths have them: of the catalogue, or "NAME@JOINT" where one joint alone has
// the effect.

#include <string>

#include "jaculus/effects/effect.h"
#include "jaculus/evaluation/predictions.h"

namespace jaculus::evaluation {

struct PlacedName {
  std::string name;   ///< in the catalogue
  std::string joint;  ///< empty: all of its scope
};
PlacedName placed_name(const std::string& name);

/// Whether a named effect is the one of this name: for one at a joint, an effect of the name that
/// says no joints or that joint among its own.
bool is_named(const std::string& actual, const NamedEffect& said);

/// The effect of a truth's name, at its one joint where it says one; nothing where the catalogue
/// has none.
std::optional<effects::Effect> placed_effect(const std::string& name);

}  // namespace jaculus::evaluation
