#include "jaculus/effects/user_effect.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "effects/families.h"
#include "effects/user/expression.h"
#include "effects/user/fit.h"
#include "effects/user/programs.h"
#include "effects/user/units.h"
#include "jaculus/core/error.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::effects {

namespace {

using simulation::Action;
using simulation::ActionKind;
using simulation::Law;
using simulation::Reading;
using simulation::ReadingKind;
using trajectory::ExperimentKind;
using Source = std::shared_ptr<Programs>;  ///< of one effect

/// Where it acts on its body; of a place that is one.
BodyPoint place_on_body(const EffectPlace& place, const PlanarModel& model) {
  BodyPoint own = *body_point(model, place.names.front());
  if (place.kind == PlaceKind::body) own.point = place.point;
  return own;
}

/// The law of an effect at one joint (empty: on its body) of a robot that can have it.
Law law_of(const Source& source, const std::string& joint, const Vector& theta,
           const PlanarModel& model) {
  const EffectSpec& spec = source->spec();
  Law law;
  law.name = spec.name;
  BodyPoint own{joint};
  if (spec.place.on_body()) own = place_on_body(spec.place, model);

  for (const ReadingName& name : source->readings()) {
    Reading reading{name.kind, name.of};
    if (name.kind == ReadingKind::time || name.kind == ReadingKind::bus_voltage) {
      reading.of.clear();
    } else if (name.of.empty()) {
      reading.of = own.body;
      reading.point = own.point;
    } else if (of_body(name.kind)) {
      const BodyPoint other = *body_point(model, name.of);
      reading.of = other.body;
      reading.point = other.point;
    }
    law.readings.push_back(reading);
  }
  for (const SpecAction& action : spec.actions) {
    const bool whole =
        action.kind == ActionKind::bus_drop || action.kind == ActionKind::friction_scale;
    law.actions.push_back({action.kind, whole ? "" : own.body, own.point});
  }

  if (!spec.states.empty()) {
    const Vector initial = Programs::lend(source, theta)->initial();
    for (int i = 0; i < count_of(spec.states); ++i)
      law.states.push_back({initial[i], spec.states[i].scale});
  }

  law.functions = [source, theta] { return law_functions(source, theta); };
  return law;
}

// The entry of the catalogue
// -------------------------------------------------------------------------------------------------

/// The part of the robot that a joint is of.
Component component_of(const PlanarModel& model, const std::string& joint) {
  const JointGroups groups = joint_groups(model);
  const auto in = [&](const JointSet& set) { return index_of(set.joints, joint) >= 0; };
  if (in(groups.tail)) return Component::tail_transmission;
  if (in(groups.front)) return Component::front_legs;
  if (in(groups.rear)) return Component::rear_legs;
  return Component::actuation;
}

std::vector<Component> where_of(const EffectSpec& spec, const PlanarModel* model,
                                const std::vector<std::string>& joints) {
  if (spec.component) return {*spec.component};
  if (spec.place.on_body()) return {Component::body};
  if (spec.place.kind == PlaceKind::sensor) return {Component::sensing};
  if (spec.place.kind == PlaceKind::part && spec.place.names.front() == "ground")
    return {Component::contact};
  if (!spec.place.at_joints()) return {Component::actuation};
  if (spec.place.kind == PlaceKind::group) {
    if (spec.place.names.front() == "tail") return tail_scope().where;
    if (spec.place.names.front() == "legs") return leg_scope().where;
    return other_scope().where;
  }
  std::vector<Component> where;
  if (model != nullptr)
    for (const std::string& joint : joints)
      if (const Component own = component_of(*model, joint); index_of(where, own) < 0)
        where.push_back(own);
  return where.empty() ? std::vector<Component>{Component::actuation} : where;
}

/// What is a value of the plant.
void apply_without_law(const Source& source, const Vector& theta, Plant& plant) {
  const EffectSpec& spec = source->spec();
  const std::shared_ptr<Program> program = Programs::lend(source, theta);
  if (spec.delay) plant.actuation.delay += std::max(0.0, program->delay());
  if (!spec.reading) return;

  auto& law = plant.sensing.laws[spec.place.names.front()];
  law = [program, before = law](double value, double t) {
    return program->reading(t, before ? before(value, t) : value);
  };
}

/// The effect at the joints that `select` gives; at its body where the place is one.
Effect entry(const Source& source,
             std::function<std::vector<std::string>(const PlanarModel&)> select) {
  const EffectSpec& spec = source->spec();
  Effect effect;
  effect.name = spec.name;
  effect.caption = spec.caption;
  effect.where = where_of(spec, nullptr, {});
  effect.excited_by = {ExperimentKind::leap, ExperimentKind::self_righting,
                       ExperimentKind::tail_bench, ExperimentKind::pendulum};
  for (const SpecParameter& p : spec.parameters) effect.parameters.push_back(p.own);

  if (spec.place.at_joints()) effect.joints = select;
  effect.applies = [source](const PlanarModel& model) {
    try {
      require_robot(source->spec(), model);
    } catch (const InputError&) {
      return false;
    }
    return true;
  };
  effect.apply = [source, select](const Vector& theta, Plant& plant) {
    const EffectSpec& own = source->spec();
    if (own.delay || own.reading) {
      apply_without_law(source, theta, plant);
      return;
    }
    if (!own.place.at_joints()) {
      plant.laws.push_back(law_of(source, "", theta, plant.model));
      return;
    }
    for (const std::string& joint : select(plant.model))
      plant.laws.push_back(law_of(source, joint, theta, plant.model));
  };
  return guarded(effect);
}

/// The effect at the joints of a scope alone.
Effect part_of(const Source& source, const JointScope& scope) {
  Effect part = entry(
      source, [select = scope.select](const PlanarModel& model) { return select(model).joints; });
  if (!source->spec().component) part.where = scope.where;
  return part;
}

/// On a robot: at all joints of the place, and at each of them alone. Legs have front and rear for
/// that.
std::vector<Effect> entries_on(const Source& source, const PlanarModel& model,
                               const std::string& file) {
  const EffectSpec& spec = source->spec();
  const std::vector<std::string> joints =
      spec.place.at_joints() ? joints_of(spec.place, model) : std::vector<std::string>{};
  std::vector<Effect> all{entry(source, [joints](const PlanarModel&) { return joints; })};
  all.front().where = where_of(spec, &model, joints);
  all.front().file = file;
  const bool legs = spec.place.kind == PlaceKind::group && spec.place.names.front() == "legs";
  if (legs && !spec.component)
    for (const JointScope& side : leg_scope().parts)
      all.front().parts.push_back(part_of(source, side));
  if (joints.size() < 2 || legs) return all;

  for (const std::string& joint : joints) {
    const std::vector<std::string> alone{joint};
    Effect one = entry(source, [alone](const PlanarModel&) { return alone; });
    one.name = spec.name + "@" + joint;
    one.file = file;
    one.where = spec.component ? std::vector<Component>{*spec.component}
                               : std::vector<Component>{component_of(model, joint)};
    all.push_back(one);
  }
  return all;
}

/// InputError at the first parameter that no formula has.
void check_used(const EffectSpec& spec, const Program& program) {
  for (const SpecParameter& parameter : spec.parameters) {
    const auto has_it = [&](const Program::Compiled& compiled) {
      const std::vector<UsedName> names = names_in(compiled.formula->text);
      return std::any_of(names.begin(), names.end(),
                         [&](const UsedName& used) { return used.name == parameter.own.name; });
    };
    if (std::none_of(program.formulas().begin(), program.formulas().end(), has_it))
      throw parameter.node.error("no formula has it; allowed: parameters that do something");
  }
}

/// `file`: as entries have it, empty where a program has the effect.
UserEffect user_effect(EffectSpec read, const std::string& file) {
  const auto source = std::make_shared<Programs>(std::move(read));
  const EffectSpec& spec = source->spec();
  Program program(spec);
  const std::vector<ReadingName>& readings = source->readings();
  // the units of other joints' readings are known with the robot
  const bool others = std::any_of(readings.begin(), readings.end(), [](const ReadingName& r) {
    return !r.of.empty() || r.kind == ReadingKind::sensor_value;
  });
  if (!others && !spec.code) check_units(program);
  check_nominal(spec, program);
  if (!spec.code) check_used(spec, program);

  UserEffect user{
      entry(source,
            [source](const PlanarModel& model) { return joints_of(source->spec().place, model); }),
      file, spec.experiment,
      [source](const PlanarModel& model) { require_units(source->spec(), model); }};
  user.effect.file = file;
  user.effect.sized = [source, file](const PlanarModel& model, const JointRates&) {
    return entries_on(source, model, file);
  };
  return user;
}

}  // namespace

UserEffect read_user_effect(const std::filesystem::path& file) {
  UserEffect user =
      user_effect(read_spec(file), std::filesystem::absolute(file).lexically_normal().string());
  user.file = file;
  return user;
}

UserEffect parse_user_effect(const std::string& text, const std::string& name) {
  const yaml::Node root = yaml::Node::parse(text, name);
  return user_effect(read_spec(root, "."), "");
}

UserEffect coded_effect(const yaml::Node& node, const EffectCode& code) {
  return user_effect(read_spec(node, code), "");
}

Catalogue catalogue_with(const std::vector<std::string>& files,
                         const std::vector<PlanarModel>& robots,
                         const std::vector<UserEffect>& coded) {
  Catalogue all = effect_catalogue();
  const auto add = [&](const UserEffect& user, const std::string& place) {
    if (find_effect(user.effect.name, all) != nullptr)
      throw InputError(fmt::format("{}: name: another {} has an effect '{}' too; allowed: once",
                                   place, user.file.empty() ? "one" : "file", user.effect.name));
    for (const PlanarModel& robot : robots) user.require(robot);
    all.push_back(user.effect);
  };
  for (const std::string& file : files) add(read_user_effect(file), file);
  for (const UserEffect& user : coded) add(user, user.effect.name);
  return all;
}

}  // namespace jaculus::effects
