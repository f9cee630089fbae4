// Files of users' effects, as far as they can be judged without a robot.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "effects/user/expression.h"
#include "effects/user/program.h"
#include "effects/user/spec.h"
#include "jaculus/core/error.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::effects {

namespace {

using simulation::ActionKind;

constexpr const char* kFormat = "jaculus-effect/1";

/// Lower-case letters, digits and _, a letter first.
void check_name(const std::string& name, const yaml::Node& node) {
  const bool good =
      !name.empty() && std::islower(static_cast<unsigned char>(name[0])) != 0 &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
  if (!good)
    throw node.error(fmt::format(
        "'{}' given; allowed: lower-case letters, digits and _, with a letter first", name));
}

/// A name in formulas, which must not stand for anything else.
void check_symbol(const std::string& name, const yaml::Node& node, const EffectSpec& spec) {
  check_name(name, node);
  const std::vector<std::string> readings = reading_names(spec.place);
  const auto in = [&](const std::vector<std::string>& list) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  const auto is = [&](const auto& item) { return item.name == name; };
  const bool own = std::any_of(spec.constants.begin(), spec.constants.end(), is) ||
                   std::any_of(spec.states.begin(), spec.states.end(), is) ||
                   std::any_of(spec.values.begin(), spec.values.end(), is) ||
                   std::any_of(spec.parameters.begin(), spec.parameters.end(),
                               [&](const SpecParameter& p) { return p.own.name == name; });
  if (in(readings) || in(function_names()) || own)
    throw node.error(fmt::format("'{}' stands for {} already; allowed: another name", name,
                                 own            ? "something in this file"
                                 : in(readings) ? "what formulas read of the robot"
                                                : "a function"));
}

/// The dimension of a unit, which must be of SI as it stands, for plain numbers are SI.
Dimension dimension_of(const yaml::Node& node) {
  const std::string unit = node.text();
  Dimension dimension;
  try {
    dimension = unit_dimension(unit);
  } catch (const InputError& e) {
    throw node.error(
        fmt::format("'{}' given: {}; allowed: a unit of SI such as N m/rad, or -", unit, e.what()));
  }
  if (unit != "-" && parse_quantity("1 " + unit, dimension) != 1.0)
    throw node.error(fmt::format("'{}' given; allowed: {}, values may be strings with a unit", unit,
                                 unit_name(dimension)));
  return dimension;
}

/// Bounds of a parameter, the lower one first.
Bounds bounds_of(const yaml::Node& node, const Dimension& dimension) {
  const std::vector<double> both = node.numbers(dimension);
  if (both.size() != 2 || !(both[0] < both[1]))
    throw node.error(fmt::format(
        "{} given; allowed: [lower, upper], the lower one first",
        both.size() == 2 ? fmt::format("[{}, {}]", both[0], both[1]) : "not two numbers"));
  return {both[0], both[1]};
}

SpecParameter parameter_of(const std::string& name, const yaml::Node& node) {
  node.only({"unit", "nominal", "bounds", "scale", "probe"});
  SpecParameter p;
  p.node = node;
  p.own.name = name;
  p.own.unit = node.at("unit").text();
  p.dimension = dimension_of(node.at("unit"));
  p.own.nominal = node.at("nominal").number(p.dimension);
  p.own.bounds = bounds_of(node.at("bounds"), p.dimension);
  if (!p.own.bounds.contains(p.own.nominal))
    throw node.at("nominal").error(fmt::format("{} given; allowed: within the bounds [{}, {}]",
                                               p.own.nominal, p.own.bounds.lower,
                                               p.own.bounds.upper));
  p.own.scale = node.at("scale").number(p.dimension);
  if (!(p.own.scale > 0.0))
    throw node.at("scale").error(fmt::format("{} given; allowed: more than 0", p.own.scale));
  if (const auto probe = node.find("probe")) p.own.probe = probe->number(p.dimension);
  if (!p.own.bounds.contains(p.own.probed()))
    throw node.at(node.has("probe") ? "probe" : "scale")
        .error(fmt::format("probing at {} leaves the bounds [{}, {}]; allowed: a `scale`, or a "
                           "`probe`, that stays within",
                           p.own.probed(), p.own.bounds.lower, p.own.bounds.upper));
  return p;
}

EffectPlace place_of(const yaml::Node& node) {
  node.only({"joint", "joints", "group", "body", "point", "part", "sensor"});
  EffectPlace place;
  place.node = node;

  int given = node.has("point") && !node.has("body") ? 1 : 0;
  for (const char* key : {"joint", "joints", "group", "body", "part", "sensor"})
    given += node.has(key) ? 1 : 0;
  if (given != 1)
    throw node.error(
        "one place is needed; allowed: joint: NAME, joints: [NAME, ...], group: tail, legs or "
        "other, body: NAME with point: [x, z], point: NAME of the robot, part: ground, battery or "
        "commands, or sensor: CHANNEL");

  if (const auto joint = node.find("joint")) place.names = {joint->text()};
  if (const auto joints = node.find("joints")) place.names = joints->texts();
  if (const auto group = node.find("group")) {
    place.kind = PlaceKind::group;
    place.names = {group->choice({"tail", "legs", "other"})};
  }
  if (const auto part = node.find("part")) {
    place.kind = PlaceKind::part;
    place.names = {part->choice({"ground", "battery", "commands"})};
  }
  if (const auto sensor = node.find("sensor")) {
    place.kind = PlaceKind::sensor;
    place.names = {sensor->text()};
  }
  if (const auto body = node.find("body")) {
    place.kind = PlaceKind::body;
    place.names = {body->text()};
    if (const auto point = node.find("point")) place.point = point->vec2(dimension::length);
  } else if (const auto point = node.find("point")) {
    place.kind = PlaceKind::point;
    place.names = {point->text()};
  }

  if (place.names.empty()) throw node.error("no joint given; allowed: one or more");
  return place;
}

/// A plain number is a formula too, and no text.
Formula formula_of(const yaml::Node& node, const Dimension& dimension) {
  const std::string plain = node.is_scalar() ? node.dump() : "";
  double number = 0.0;
  const auto [end, code] = std::from_chars(plain.data(), plain.data() + plain.size(), number);
  const bool is_number = code == std::errc() && end == plain.data() + plain.size();
  return {is_number ? plain : node.text(), dimension, node};
}

/// A key that says what an effect does, and at which places it may.
struct ActionKey {
  const char* key;
  ActionKind kind;
  Dimension dimension;
  bool (*fits)(const EffectPlace&);
  const char* where;
};

bool is_part(const EffectPlace& place, const char* name) {
  return place.kind == PlaceKind::part && place.names.front() == name;
}
bool at_joint(const EffectPlace& place) { return place.at_joints(); }
bool on_body(const EffectPlace& place) { return place.on_body(); }
bool at_battery(const EffectPlace& place) { return place.at_joints() || is_part(place, "battery"); }
bool at_ground(const EffectPlace& place) { return is_part(place, "ground"); }

const ActionKey kActions[] = {
    {"torque", ActionKind::joint_torque, dimension::torque, at_joint, "at a joint that turns"},
    {"force", ActionKind::joint_torque, dimension::force, at_joint, "at a joint that slides"},
    {"torque_scale", ActionKind::torque_scale, dimension::none, at_joint, "at a joint"},
    {"force", ActionKind::point_force, dimension::force, on_body, "{x, z} on a body or point"},
    {"moment", ActionKind::body_moment, dimension::torque, on_body, "on a body or point"},
    {"bus_drop", ActionKind::bus_drop, dimension::voltage, at_battery, "at a joint or the battery"},
    {"friction_scale", ActionKind::friction_scale, dimension::none, at_ground, "at the ground"},
};

/// Every key with where it may stand: "torque at a joint that turns, ...".
std::string all_actions() {
  std::string text;
  for (const ActionKey& action : kActions) text += fmt::format("{} {}, ", action.key, action.where);
  return text + "delay at the commands, reading at a sensor";
}

constexpr const char* kMisplaced = "doesn't act at this place; allowed: ";

InputError misplaced(const yaml::Node& node) { return node.error(kMisplaced + all_actions()); }

void add_action(const ActionKey& action, const yaml::Node& node, EffectSpec& spec) {
  if (action.kind != ActionKind::point_force) {
    spec.actions.push_back({action.kind, {formula_of(node, action.dimension)}});
    return;
  }
  node.only({"x", "z"});
  spec.actions.push_back(
      {action.kind,
       {formula_of(node.at("x"), action.dimension), formula_of(node.at("z"), action.dimension)}});
}

void read_actions(const yaml::Node& root, EffectSpec& spec) {
  for (const ActionKey& action : kActions) {
    const auto node = root.find(action.key);
    const auto fits = [&](const ActionKey& a) {
      return std::string(a.key) == action.key && a.fits(spec.place);
    };
    if (!node) continue;
    if (std::none_of(std::begin(kActions), std::end(kActions), fits)) throw misplaced(*node);
    if (!action.fits(spec.place)) continue;
    if (spec.place.slides && action.kind == ActionKind::joint_torque && root.has("torque"))
      throw root.at("torque").error("stands beside force; allowed: one of them at a joint");
    add_action(action, *node, spec);
  }

  if (const auto delay = root.find("delay")) {
    if (!is_part(spec.place, "commands")) throw misplaced(*delay);
    spec.delay = formula_of(*delay, dimension::time);
  }
  if (const auto reading = root.find("reading")) {
    if (spec.place.kind != PlaceKind::sensor) throw misplaced(*reading);
    if (!spec.states.empty())
      throw reading->error("has states beside it; allowed: a formula of value and t alone");
    spec.reading = formula_of(*reading, spec.place.channel_dimension());
  }
  if (spec.actions.empty() && !spec.delay && !spec.reading)
    throw root.error("does nothing; allowed: " + all_actions());
}

void read_states(const yaml::Node& root, EffectSpec& spec) {
  const auto states = root.find("states");
  if (!states) return;
  for (const auto& [name, node] : states->entries()) {
    check_symbol(name, node, spec);
    if (spec.code)
      node.only({"unit", "initial", "scale"});
    else
      node.only({"unit", "initial", "derivative", "scale"});
    SpecState state;
    state.name = name;
    state.dimension = dimension_of(node.at("unit"));
    if (const auto scale = node.find("scale")) {
      state.scale = scale->number(state.dimension);
      if (!(state.scale > 0.0))
        throw scale->error(fmt::format("{} given; allowed: more than 0", state.scale));
    }
    Dimension rate = state.dimension;
    rate.second -= 1;
    state.initial = formula_of(node.at("initial"), state.dimension);
    if (!spec.code) state.derivative = formula_of(node.at("derivative"), rate);
    spec.states.push_back(state);
  }
}

}  // namespace

Dimension EffectPlace::channel_dimension() const {
  const trajectory::ChannelName channel = trajectory::parse_channel(names.front());
  const bool metres = slides || channel.of == "x" || channel.of == "z";
  return unit_dimension(trajectory::unit_of(channel.quantity, metres));
}

namespace {

/// Name, caption and place.
void read_head(const yaml::Node& root, EffectSpec& spec) {
  spec.node = root;
  if (const yaml::Node format = root.at("format"); format.text() != kFormat)
    throw format.error(fmt::format("'{}' given; allowed: {}", format.text(), kFormat));
  spec.name = root.at("name").text();
  check_name(spec.name, root.at("name"));
  if (find_effect(spec.name) != nullptr)
    throw root.at("name").error(
        fmt::format("'{}' is an effect of jaculus; allowed: another name", spec.name));
  spec.caption = root.at("caption").text();
  spec.place = place_of(root.at("at"));
  if (const auto component = root.find("component")) {
    std::vector<std::string> names;
    for (int c = 0; c < kComponentCount; ++c)
      names.emplace_back(component_name(static_cast<Component>(c)));
    spec.component = static_cast<Component>(index_of(names, component->choice(names)));
  }
}

void read_parameters(const yaml::Node& root, EffectSpec& spec) {
  for (const auto& [name, node] : root.at("parameters").entries()) {
    check_symbol(name, node, spec);
    spec.parameters.push_back(parameter_of(name, node));
  }
  if (spec.parameters.empty())
    throw root.at("parameters").error("none given; allowed: one or more, the first switches it on");
}

/// The readings and actions of code, as far as they can be judged without a robot.
void take_code(const yaml::Node& root, EffectSpec& spec) {
  const EffectPlace& place = spec.place;
  for (const std::string& key : spec.code->actions) {
    const ActionKey* found = nullptr;
    for (const ActionKey& action : kActions)
      if (key == action.key && action.fits(place)) found = &action;
    if (found == nullptr) throw root.error(fmt::format("{}: {}", key, kMisplaced + all_actions()));
    spec.actions.push_back({found->kind, {}});
  }
  if (spec.actions.empty()) throw root.error("does nothing; allowed: " + all_actions());

  const bool early = std::any_of(spec.actions.begin(), spec.actions.end(), [](const auto& action) {
    return simulation::Action{action.kind}.before_motors();
  });
  for (const std::string& name : spec.code->reads) {
    const auto reading = reading_named(name, place);
    if (!reading)
      throw root.error(
          fmt::format("unknown name '{}'; allowed: parameters, states, {}, and "
                      "JOINT.q or BODY.x of others",
                      name, fmt::join(reading_names(place), ", ")));
    if (early && of_motors(reading->kind))
      throw root.error(fmt::format(
          "'{}' follows from what this changes; allowed: what doesn't, or a state that follows it",
          name));
  }
}

}  // namespace

EffectSpec read_spec(const std::filesystem::path& file) {
  return read_spec(yaml::Node::load(file), file.parent_path());
}

EffectSpec read_spec(const yaml::Node& root, const std::filesystem::path& folder) {
  yaml::refuse_other_kind(root, kFormat);
  root.only({"format", "name", "caption", "at", "component", "experiment", "parameters",
             "constants", "states", "values", "torque", "force", "moment", "torque_scale",
             "bus_drop", "friction_scale", "delay", "reading"});
  EffectSpec spec;
  read_head(root, spec);
  spec.place.slides = spec.place.at_joints() && root.has("force");
  if (const auto experiment = root.find("experiment")) {
    spec.experiment = folder / experiment->text();
    if (!std::filesystem::is_regular_file(spec.experiment))
      throw experiment->error(fmt::format(
          "'{}' given, and there is no such file; allowed: an experiment, from this file's folder",
          experiment->text()));
  }

  read_parameters(root, spec);
  if (const auto constants = root.find("constants")) {
    for (const auto& [name, node] : constants->entries()) {
      check_symbol(name, node, spec);
      node.only({"unit", "value"});
      const Dimension dimension = dimension_of(node.at("unit"));
      spec.constants.push_back({name, node.at("value").number(dimension), dimension});
    }
  }
  read_states(root, spec);
  if (const auto values = root.find("values")) {
    for (const auto& [name, node] : values->entries()) {
      check_symbol(name, node, spec);
      node.only({"unit", "value"});
      spec.values.push_back({name, formula_of(node.at("value"), dimension_of(node.at("unit")))});
    }
  }
  read_actions(root, spec);
  return spec;
}

EffectSpec read_spec(const yaml::Node& root, const EffectCode& code) {
  root.only({"format", "name", "caption", "at", "component", "parameters", "states"});
  EffectSpec spec;
  spec.code = code;
  read_head(root, spec);
  const bool force =
      std::find(code.actions.begin(), code.actions.end(), "force") != code.actions.end();
  spec.place.slides = spec.place.at_joints() && force;
  read_parameters(root, spec);
  read_states(root, spec);
  take_code(root, spec);
  return spec;
}

}  // namespace jaculus::effects
