#include "evaluation/names.h"

#include <algorithm>

#include "effects/scope.h"

namespace jaculus::evaluation {

PlacedName placed_name(const std::string& name) {
  const std::size_t at = name.find('@');
  if (at == std::string::npos) return {name, ""};
  return {name.substr(0, at), name.substr(at + 1)};
}

bool is_named(const std::string& actual, const NamedEffect& said) {
  const PlacedName wanted = placed_name(actual), given = placed_name(said.name);
  if (wanted.name != given.name) return false;
  if (wanted.joint.empty() || (said.joints.empty() && given.joint.empty())) return true;
  return given.joint == wanted.joint ||
         std::find(said.joints.begin(), said.joints.end(), wanted.joint) != said.joints.end();
}

std::optional<effects::Effect> placed_effect(const std::string& name) {
  const PlacedName placed = placed_name(name);
  const effects::Effect* everywhere = effects::find_effect(placed.name);
  if (everywhere == nullptr) return {};
  if (placed.joint.empty()) return *everywhere;

  // The same row of the catalogue, made for the one joint: rows keep their order, and one joint has
  // an entry for each that its scope has.
  for (const effects::JointScope* scope :
       {&effects::tail_scope(), &effects::leg_scope(), &effects::other_scope()}) {
    const std::vector<effects::Effect> all = effects::effects_on(*scope);
    const std::vector<effects::Effect> here =
        effects::effects_on(effects::one_joint(*scope, placed.joint));
    for (int i = 0; i < count_of(all) && all.size() == here.size(); ++i)
      if (all[i].name == placed.name) return here[i];
  }
  return {};
}

}  // namespace jaculus::evaluation
