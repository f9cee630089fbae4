// The table of candidate effects: the rows of all families, made for their scopes.

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "effects/families.h"

namespace jaculus::effects {
namespace {

const std::vector<Row>& rows() {
  static const std::vector<Row> all = [] {
    std::vector<Row> list;
    for (const auto family : {transmission, actuation, aerodynamics, inertia, contact, sensing}) {
      const std::vector<Row> own = family();
      list.insert(list.end(), own.begin(), own.end());
    }
    return list;
  }();
  return all;
}

/// A row's effect on a scope's joints, and on each part of them where shares tell the parts apart.
Effect with_parts(const Row& row, const JointScope& scope) {
  Effect effect = guarded(row.on_joints(scope));
  for (const JointScope& part : scope.parts)
    if (effect.acts_in(part.where.front())) effect.parts.push_back(guarded(row.on_joints(part)));
  return effect;
}

/// The same with a robot's sizes.
Effect made_to_size(const Row& row, const JointScope& scope, const PlanarModel& model,
                    const JointRates& rates) {
  Effect effect = with_parts(row, sized_scope(scope, model, rates));
  if (all_slide(scope, model)) use_sliding_units(effect);
  return effect;
}

/// The front or the rear legs where the joint is one of theirs, else the scope itself.
const JointScope& part_with(const JointScope& scope, const std::string& joint,
                            const PlanarModel& model) {
  for (const JointScope& part : scope.parts)
    if (index_of(part.select(model).joints, joint) >= 0) return part;
  return scope;
}

/// An effect on a robot's joints together, and at each of them alone. One joint's links that are
/// all links say nothing of their own, and links of a leg's loop no joint has for itself.
std::vector<Effect> at_joints(const Row& row, const JointScope& scope, const PlanarModel& model,
                              const JointRates& rates) {
  std::vector<Effect> effects{made_to_size(row, scope, model, rates)};
  const JointSet all = scope.select(model);
  if (all.joints.size() < 2) return effects;

  const bool on_links = effects.front().where == scope.links_where;
  const bool legs = !scope.parts.empty();
  if (legs && on_links) return effects;
  for (const std::string& joint : all.joints) {
    const JointScope one = one_joint(part_with(scope, joint, model), joint);
    if (on_links && one.select(model).bodies.size() == all.bodies.size()) continue;
    Effect effect = made_to_size(row, one, model, rates);
    effect.name = effects.front().name + "@" + joint;
    if (!effect.special_case.empty())
      effect.special_case = effects.front().special_case + "@" + joint;
    effects.push_back(effect);
  }
  return effects;
}

/// A uniform bar has the spread half/sqrt(3).
const double kHalfOfSpread = std::sqrt(3.0);
/// Of the longer side, what a plate's or a rod's other side is at least: files have none of it.
constexpr double kThinnest = 0.1;

/// Minitaur's, as in its URDF.
BaseSize usual_base() { return {6.192, Vec2::Zero(), kHalfOfSpread * Vec2(0.167, 0.0367)}; }

/// Where no file says along which axis the mass is spread, along both alike.
BaseSize base_size(const PlanarModel& model) {
  const PlanarBody& base = model.bodies.front();
  Vec2 spread = base.spread;
  if (spread.isZero()) spread.setConstant(std::sqrt(0.5 * base.inertia / base.mass));
  spread = spread.cwiseMax(kThinnest * spread.maxCoeff());
  return {base.mass, base.com, kHalfOfSpread * spread};
}

Effect made_for_base(const Row& row) {
  Effect effect = guarded(row.on_base(usual_base()));
  effect.sized = [row](const PlanarModel& model, const JointRates&) -> std::vector<Effect> {
    return {guarded(row.on_base(base_size(model)))};
  };
  return effect;
}

Effect made_for(const Row& row, const JointScope& scope) {
  Effect effect = with_parts(row, scope);
  effect.sized = [row, scope](const PlanarModel& model, const JointRates& rates) {
    return at_joints(row, scope, model, rates);
  };
  return effect;
}

void add_parameter_faults(const Effect& effect, const EffectParameter& p,
                          std::vector<std::string>& faults) {
  const std::string place = effect.name + ": " + p.name + ": ";
  const auto& [lower, upper] = p.bounds;

  if (!(lower < upper))
    faults.push_back(fmt::format("{}bounds [{}, {}] are empty", place, lower, upper));
  if (!p.bounds.contains(p.nominal)) {
    faults.push_back(fmt::format("{}nominal {} lies outside its bounds [{}, {}]", place, p.nominal,
                                 lower, upper));
  }
  if (!(p.scale > 0.0) || !std::isfinite(p.scale)) {
    faults.push_back(
        fmt::format("{}scale {} of the prior is not positive and finite", place, p.scale));
  }
  if (!p.bounds.contains(p.probed())) {
    faults.push_back(
        fmt::format("{}probing at {} leaves the bounds [{}, {}]", place, p.probed(), lower, upper));
  }
}

}  // namespace

Effect guarded(Effect effect) {
  effect.apply = [inner = effect.apply, nominal = effect.nominal()](const Vector& theta,
                                                                    Plant& plant) {
    assert(theta.size() == nominal.size() && "apply: one value a parameter");
    if (theta != nominal) inner(theta, plant);
  };
  effect.overrides = [inner = effect.overrides, nominal = effect.nominal()](
                         const Vector& theta, const PlanarModel& model) {
    return inner && theta != nominal ? inner(theta, model) : std::vector<ModelOverride>();
  };
  return effect;
}

const char* component_name(Component component) {
  static const NameTable<Component> table({{Component::tail_transmission, "tail_transmission"},
                                           {Component::tail_aerodynamics, "tail_aerodynamics"},
                                           {Component::actuation, "actuation"},
                                           {Component::front_legs, "front_legs"},
                                           {Component::rear_legs, "rear_legs"},
                                           {Component::contact, "contact"},
                                           {Component::body, "body"},
                                           {Component::sensing, "sensing"}});
  return table.name(component);
}

double EffectParameter::probed() const {
  const double step = std::isnan(probe) ? scale : probe;
  return nominal == bounds.upper ? nominal - step : nominal + step;
}

Vector Effect::nominal() const {
  Vector theta(parameters.size());
  for (Eigen::Index i = 0; i < theta.size(); ++i) theta[i] = parameters[i].nominal;
  return theta;
}

Vector Effect::probed() const {
  Vector theta(parameters.size());
  for (Eigen::Index i = 0; i < theta.size(); ++i) theta[i] = parameters[i].probed();
  return theta;
}

bool Effect::acts_in(Component component) const {
  return std::find(where.begin(), where.end(), component) != where.end();
}

std::vector<const Effect*> in_parts(const Effect& effect) {
  if (effect.parts.empty()) return {&effect};

  std::vector<const Effect*> parts;
  for (const Effect& part : effect.parts) parts.push_back(&part);
  return parts;
}

std::vector<Effect> sized_for(const Effect& effect, const PlanarModel& model,
                              const JointRates& rates) {
  return effect.sized ? effect.sized(model, rates) : std::vector<Effect>{effect};
}

std::vector<Effect> effects_of(const std::vector<Row>& rows) {
  std::vector<Effect> effects;
  for (const Row& row : rows) {
    if (row.whole != nullptr) effects.push_back(guarded(row.whole()));
    if (row.on_base != nullptr) effects.push_back(made_for_base(row));
    for (const JointScope& scope : row.scopes) effects.push_back(made_for(row, scope));
  }
  return effects;
}

const Catalogue& effect_catalogue() {
  static const Catalogue catalogue = effects_of(rows());
  return catalogue;
}

std::vector<Effect> effects_on(const JointScope& scope) {
  std::vector<Effect> effects;
  for (const Row& row : rows())
    if (!row.scopes.empty()) effects.push_back(made_for(row, scope));
  return effects;
}

const Effect* find_effect(const std::string& name, const Catalogue& catalogue) {
  const auto found = std::find_if(catalogue.begin(), catalogue.end(),
                                  [&](const Effect& e) { return e.name == name; });
  return found == catalogue.end() ? nullptr : &*found;
}

std::vector<const Effect*> applicable_effects(const PlanarModel& model,
                                              const Catalogue& catalogue) {
  std::vector<const Effect*> effects;
  for (const Effect& effect : catalogue)
    if (effect.applies(model)) effects.push_back(&effect);
  return effects;
}

std::vector<std::string> effect_faults(const Effect& effect) {
  std::vector<std::string> faults;
  if (effect.name.empty()) faults.emplace_back("an effect has no name");
  if (effect.where.empty()) faults.push_back(effect.name + ": acts nowhere");
  if (effect.parameters.empty()) faults.push_back(effect.name + ": has no parameter");
  if (effect.excited_by.empty()) faults.push_back(effect.name + ": no experiment excites it");
  if (!effect.applies || !effect.apply) faults.push_back(effect.name + ": lacks a function");
  for (const EffectParameter& p : effect.parameters) add_parameter_faults(effect, p, faults);
  return faults;
}

}  // namespace jaculus::effects
