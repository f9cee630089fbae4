// The explicit table of candidate effects: one row an effect.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "effects/families.h"

namespace jaculus {
namespace {

std::vector<Effect> rows() {
  using namespace effects;
  const Group &tail = tail_group(), &legs = leg_group(), &other = other_group();
  return {
      compliance(tail),
      compliance(other),
      backlash(tail),
      backlash(legs),
      backlash(other),
      stop_restitution(),
      coulomb_friction(tail),
      coulomb_friction(legs),
      coulomb_friction(other),
      viscous_friction(tail),
      viscous_friction(legs),
      viscous_friction(other),
      stribeck_friction(tail),
      stribeck_friction(legs),
      stribeck_friction(other),
      load_friction(tail),
      load_friction(legs),
      load_friction(other),
      actuation_delay(),
      late_start(),
      controller_gains(),
      torque_constant(),
      voltage_limit(),
      current_limit(),
      battery_sag(),
      winding_heating(),
      drag_coefficient(),
      drag_without_translation(),
      wind(),
      rotor_inertia(tail),
      rotor_inertia(legs),
      rotor_inertia(other),
      link_inertia(tail),
      link_inertia(legs),
      link_inertia(other),
      link_mass(tail),
      link_mass(other),
      payload(),
      com_shift(),
      body_inertia(),
      foot_friction(),
      ground_compliance(),
      foot_radius(),
      joint_offset(tail),
      joint_offset(legs),
      joint_offset(other),
      sensor_latency(),
      mocap_scale(),
      joint_scale(other),
  };
}

/// At nominal values an effect leaves the plant alone: not even an entry of zeros is added.
Effect guarded(Effect effect) {
  effect.apply = [inner = effect.apply, nominal = effect.nominal()](const Vector& theta, Plant& plant) {
    assert(theta.size() == nominal.size() && "apply: one value a parameter");
    if (theta != nominal) inner(theta, plant);
  };
  const auto none = [](const Vector&, const PlanarModel&) { return std::vector<ModelOverride>(); };
  if (!effect.overrides) {
    effect.overrides = none;
    return effect;
  }
  effect.overrides = [inner = effect.overrides, nominal = effect.nominal()](const Vector& theta,
                                                                            const PlanarModel& model) {
    return theta == nominal ? std::vector<ModelOverride>() : inner(theta, model);
  };
  return effect;
}

void add_parameter_faults(const Effect& effect, const EffectParameter& p, std::vector<std::string>& faults) {
  const std::string place = effect.name + ": " + p.name + ": ";
  const auto& [lower, upper] = p.bounds;
  if (!(lower < upper)) faults.push_back(fmt::format("{}bounds [{}, {}] are empty", place, lower, upper));
  if (!p.bounds.contains(p.nominal)) {
    faults.push_back(fmt::format("{}nominal {} lies outside its bounds [{}, {}]", place, p.nominal, lower, upper));
  }
  if (!(p.scale > 0.0) || !std::isfinite(p.scale)) {
    faults.push_back(fmt::format("{}scale {} of the prior is not positive and finite", place, p.scale));
  }
  if (!p.bounds.contains(p.probed())) {
    faults.push_back(fmt::format("{}probing at {} leaves the bounds [{}, {}]", place, p.probed(), lower, upper));
  }
  if (!p.shown_as.empty() && p.shown_as != "reciprocal") {
    faults.push_back(fmt::format("{}shown as '{}'; allowed: reciprocal", place, p.shown_as));
  }
}

}  // namespace

const char* component_name(Component component) {
  static constexpr std::array<const char*, kComponentCount> names = {
      "tail_transmission", "tail_aerodynamics", "actuation", "front_legs", "rear_legs", "contact", "body", "sensing"};
  return names[static_cast<std::size_t>(component)];
}

double EffectParameter::probed() const {
  const double step = std::isnan(probe) ? scale : probe;
  return nominal == bounds.upper ? nominal - step : nominal + step;
}

Vector Effect::nominal() const {
  Vector theta(static_cast<Eigen::Index>(parameters.size()));
  for (Eigen::Index i = 0; i < theta.size(); ++i) theta[i] = parameters[static_cast<std::size_t>(i)].nominal;
  return theta;
}

Vector Effect::probed() const {
  Vector theta(static_cast<Eigen::Index>(parameters.size()));
  for (Eigen::Index i = 0; i < theta.size(); ++i) theta[i] = parameters[static_cast<std::size_t>(i)].probed();
  return theta;
}

bool Effect::acts_in(Component component) const {
  return where == component || std::find(also.begin(), also.end(), component) != also.end();
}

const std::vector<Effect>& effect_catalogue() {
  static const std::vector<Effect> catalogue = [] {
    std::vector<Effect> effects;
    for (Effect& effect : rows()) effects.push_back(guarded(std::move(effect)));
    return effects;
  }();
  return catalogue;
}

const Effect* find_effect(const std::string& name) {
  const std::vector<Effect>& all = effect_catalogue();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Effect& e) { return e.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::vector<const Effect*> applicable_effects(const PlanarModel& model) {
  std::vector<const Effect*> effects;
  for (const Effect& effect : effect_catalogue()) {
    if (effect.applies(model)) effects.push_back(&effect);
  }
  return effects;
}

std::vector<std::string> effect_faults(const Effect& effect) {
  std::vector<std::string> faults;
  if (effect.name.empty()) faults.emplace_back("an effect has no name");
  if (effect.parameters.empty()) faults.push_back(effect.name + ": has no parameter");
  if (effect.excited_by.empty()) faults.push_back(effect.name + ": no experiment excites it");
  if (!effect.applies || !effect.apply) faults.push_back(effect.name + ": lacks a function");
  for (const EffectParameter& p : effect.parameters) add_parameter_faults(effect, p, faults);
  return faults;
}

}  // namespace jaculus
