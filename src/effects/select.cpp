#include "jaculus/effects/select.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cassert>
#include <cmath>
#include <set>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"

namespace jaculus::effects {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t from = 0;;) {
    const std::size_t to = text.find(separator, from);
    parts.push_back(text.substr(from, to == std::string::npos ? to : to - from));
    if (to == std::string::npos) return parts;
    from = to + 1;
  }
}

/// Every effect that this robot can have, with its sizes, each joint's own among them.
std::vector<Effect> effects_of(const model::PlanarModel& model, const Catalogue& catalogue) {
  std::vector<Effect> all;
  for (const Effect* effect : applicable_effects(model, catalogue))
    for (Effect& own : sized_for(*effect, model, {})) all.push_back(std::move(own));
  return all;
}

std::shared_ptr<const Effect> effect_named(const std::string& name, const model::PlanarModel& model,
                                           const std::string& place, const Catalogue& catalogue) {
  std::vector<std::string> names;
  for (Effect& effect : effects_of(model, catalogue)) {
    if (effect.name == name) return std::make_shared<const Effect>(std::move(effect));
    names.push_back(effect.name);
  }

  const Effect* other = find_effect(name, catalogue);
  if (other == nullptr) {
    throw InputError(fmt::format("{}: unknown effect '{}'{}; allowed: {}", place, name,
                                 yaml::did_you_mean(name, names), fmt::join(names, ", ")));
  }
  throw InputError(fmt::format("{}: this robot can't have '{}' ({}); allowed: {}", place, name,
                               other->caption, fmt::join(names, ", ")));
}

double number_in(const std::string& text, const std::string& place) {
  std::size_t used = 0;
  double value = kNaN;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || std::isnan(value)) {
    throw InputError(fmt::format("{}: '{}' given; allowed: a number in SI units", place, text));
  }
  return value;
}

void set_parameter(const std::string& assignment, EffectValue& value, std::set<std::size_t>& seen,
                   const std::string& place) {
  const std::size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  std::vector<std::string> names;
  for (int i = 0; i < count_of(value.effect->parameters); ++i) {
    const EffectParameter& p = value.effect->parameters[i];
    names.push_back(p.name);
    if (p.reciprocal) names.push_back(p.reciprocal->name);
    if (name != p.name && name != p.shown_name()) continue;

    const std::string key = fmt::format("{}: {}: {}", place, value.effect->name, name);
    if (equals == std::string::npos)
      throw InputError(fmt::format("{}: no value given; allowed: {}=number", key, name));
    if (!seen.insert(i).second) throw InputError(key + ": given twice; allowed: once");
    const double given = number_in(assignment.substr(equals + 1), key);
    const double own = name == p.name ? given : own_value(p, given);
    if (!p.bounds.contains(own)) {
      double from = p.bounds.lower, to = p.bounds.upper;
      if (name != p.name) std::tie(from, to) = std::pair(shown_value(p, to), shown_value(p, from));
      throw InputError(fmt::format("{}: {} given; allowed: {} to {} {}", key, given, from, to,
                                   name == p.name ? p.unit : p.shown_unit()));
    }
    value.theta[i] = own;
    return;
  }
  throw InputError(fmt::format("{}: {}: unknown parameter '{}'{}; allowed: {}", place,
                               value.effect->name, name, yaml::did_you_mean(name, names),
                               fmt::join(names, ", ")));
}

}  // namespace

EffectValue read_effect(const std::string& text, const model::PlanarModel& model,
                        const std::string& place, const Catalogue& catalogue) {
  const std::size_t colon = text.find(':');
  const std::shared_ptr<const Effect> effect =
      effect_named(text.substr(0, colon), model, place, catalogue);
  if (colon == std::string::npos) {
    throw InputError(fmt::format(
        "{}: '{}' has no parameter; allowed: name:parameter=value,... such as {}:{}={}", place,
        text, effect->name, effect->parameters.front().name, effect->parameters.front().probed()));
  }
  EffectValue value{effect, effect->nominal()};
  std::set<std::size_t> seen;
  for (const std::string& part : split(text.substr(colon + 1), ','))
    set_parameter(part, value, seen, place);
  return value;
}

AugmentedEffects read_augmented(const std::filesystem::path& file) {
  const yaml::Node root = yaml::Node::load(file);
  root.only({"format", "robot", "override", "effects", "effect_files"});
  if (const yaml::Node format = root.at("format"); format.text() != "jaculus-augmented/1")
    throw format.error(
        fmt::format("'{}' given; allowed: jaculus-augmented/1, as diagnose writes", format.text()));
  AugmentedEffects augmented;
  augmented.effects = root.at("effects").texts();
  if (const auto files = root.find("effect_files")) augmented.files = files->texts();
  return augmented;
}

void apply_effects(const std::vector<EffectValue>& effects, simulation::Plant& plant) {
  for (const EffectValue& value : effects) value.effect->apply(value.theta, plant);
}

double shown_value(const EffectParameter& parameter, double value) {
  return parameter.reciprocal ? 1.0 / value : value;
}

double own_value(const EffectParameter& parameter, double shown) {
  return parameter.reciprocal ? 1.0 / shown : shown;
}

std::vector<ShownParameter> shown_parameters(const Effect& effect, const Vector& theta) {
  assert(theta.size() == std::ssize(effect.parameters));
  std::vector<ShownParameter> shown;
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    const EffectParameter& p = effect.parameters[i];
    shown.push_back({p.shown_name(), shown_value(p, theta[i]), p.shown_unit()});
  }
  return shown;
}

std::string catalogue_text(const Catalogue& catalogue) {
  std::string text;
  for (const Effect& effect : catalogue) {
    std::vector<std::string> where, shown_by;
    for (const Component component : effect.where) where.emplace_back(component_name(component));
    for (const trajectory::ExperimentKind kind : effect.excited_by)
      shown_by.emplace_back(trajectory::name_of(kind));

    text += fmt::format("\n{}: {}\n", effect.name, effect.caption);
    text += fmt::format("  acts in {}; shown by {}{}\n", fmt::join(where, ", "),
                        fmt::join(shown_by, ", "),
                        effect.sized ? "; bounds and priors are made to the robot's size" : "");
    for (const EffectParameter& p : effect.parameters) {
      text += fmt::format(
          "  {:<22} {:<12} {:.6g}, {:.6g} to {:.6g}, prior {:.6g}{}\n", p.name, p.unit, p.nominal,
          p.bounds.lower, p.bounds.upper, p.scale,
          p.reciprocal ? fmt::format("; read as {} [{}]", p.reciprocal->name, p.reciprocal->unit)
                       : "");
    }
  }
  return text;
}

}  // namespace jaculus::effects
