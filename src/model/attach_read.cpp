// `attach` of robot.yaml, read and checked as far as that goes without the robot's bodies.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/attach.h"
#include "model/sections.h"

namespace jaculus::model {
namespace {

constexpr Bounds kAbove{1e-9, kInfinity};              ///< more than nothing
constexpr double kScoopDrag = 2.0;                     ///< C_D of Minitaur's scoop on the bench [-]
constexpr Bounds kTailRange{-M_PI / 2.0, M_PI / 2.0};  ///< Minitaur's [rad]

const std::vector<std::string> kTailKinds = {"none", "inertial", "drag"};  // in TailKind's order

std::vector<std::string> key_names() {
  std::vector<std::string> names;
  for (const AttachKey& key : attach_keys()) names.emplace_back(key.name);
  return names;
}

/// One entry of `attach`, its overrides in front of what the file says.
class Keys {
 public:
  Keys(const std::string& name, const yaml::Node& node, const std::vector<OverrideInput>& overrides)
      : name_(name), node_(node), overrides_(overrides) {
    node.only(key_names());
  }

  [[nodiscard]] std::optional<yaml::Node> find(const std::string& key) const {
    for (const OverrideInput& o : overrides_)
      if (o.path == "attach." + name_ + "." + key) return o.value;
    return node_.find(key);
  }

  [[nodiscard]] yaml::Node at(const std::string& key) const {
    const auto found = find(key);
    return found ? *found : node_.at(key);
  }

  [[nodiscard]] bool changed(const std::string& key) const {
    return std::any_of(overrides_.begin(), overrides_.end(), [&](const OverrideInput& o) {
      return o.path == "attach." + name_ + "." + key;
    });
  }

  [[nodiscard]] double number(const std::string& key, const Dimension& dimension,
                              const Bounds& allowed, double absent) const {
    const auto found = find(key);
    return found ? found->number(dimension, allowed) : absent;
  }

 private:
  const std::string& name_;
  const yaml::Node& node_;
  const std::vector<OverrideInput>& overrides_;
};

/// kg, or a share of the robot's own mass: "10 %".
double mass_of(const yaml::Node& node, double robot_mass) {
  const bool share = node.is_scalar() && node.dump().find('%') != std::string::npos;
  return share ? node.number(dimension::none, {kAbove.lower, 1.0}) * robot_mass
               : node.number(dimension::mass, kAbove);
}

/// Two of length, shaft and scoop give the third.
void read_lengths(const Keys& keys, const yaml::Node& node, Attachment& tail) {
  const auto of = [&](const char* key) { return keys.number(key, dimension::length, kAbove, 0.0); };
  const double length = of("length"), shaft = of("shaft"), scoop = of("scoop");
  const int given = (length > 0.0) + (shaft > 0.0) + (scoop > 0.0);
  const bool drags = tail.kind == TailKind::drag;

  if (length == 0.0 && (shaft == 0.0 || scoop == 0.0))
    throw node.error("length is missing; allowed: length, or shaft and scoop");
  if (drags && given < 2) {
    throw node.error(
        "length alone doesn't say where the air acts; allowed: shaft or scoop with it, or kind: "
        "inertial");
  }

  tail.length = length > 0.0 ? length : shaft + scoop;
  tail.scoop = scoop > 0.0 ? scoop : shaft > 0.0 ? tail.length - shaft : 0.0;
  constexpr double kRounding = 1e-6;  // [m]
  if (given == 3 && std::abs(shaft + scoop - length) > kRounding) {
    const char* told = "length";  // or where an override of another brought it about
    if (!keys.changed("length"))
      for (const char* other : {"scoop", "shaft"})
        if (keys.changed(other)) told = other;
    throw keys.at(told).error(
        fmt::format("length is {:.6g} m, but shaft and scoop are {:.6g} m together; allowed: "
                    "two of the three, or three that agree",
                    length, shaft + scoop));
  }
  if (tail.scoop < 0.0 || tail.scoop > tail.length) {
    const char* part = scoop > 0.0 ? "scoop" : "shaft";
    const double own = scoop > 0.0 ? scoop : shaft;
    if (keys.changed("length") && !keys.changed(part))
      throw keys.at("length").error(fmt::format(
          "{:.6g} m given with a {} of {:.6g} m; allowed: at least that", tail.length, part, own));
    throw keys.at(part).error(fmt::format(
        "{:.6g} m given on a tail of {:.6g} m; allowed: at most its length", own, tail.length));
  }
}

void read_tail(const Keys& keys, const yaml::Node& node, double robot_mass, Attachment& tail) {
  read_lengths(keys, node, tail);
  tail.mass = mass_of(keys.at("mass"), robot_mass);
  tail.scoop_mass = tail.mass * tail.scoop / tail.length;
  if (const auto given = keys.find("scoop_mass")) {
    tail.scoop_mass = given->number(dimension::mass, {0.0, tail.mass});
    if (tail.scoop == 0.0 && tail.scoop_mass > 0.0)
      throw given->error("given without a scoop; allowed: with scoop, or shaft and length");
  }

  const bool drags = tail.kind == TailKind::drag;
  tail.width = drags ? keys.at("width").number(dimension::length, kAbove)
                     : keys.number("width", dimension::length, kAbove, 0.0);
  tail.coefficient = keys.number("coefficient", dimension::none, {0.0, kInfinity}, kScoopDrag);
  tail.density = keys.number("density", dimension::density, {0.0, kInfinity}, PlanarDrag{}.density);
  tail.range = kTailRange;
  if (const auto range = keys.find("range")) tail.range = range->bounds(dimension::angle);
  tail.motor = keys.at("motor");
  if (const auto gear = keys.find("gear")) tail.gear = gear->number(dimension::none, kAbove);
}

Attachment read_one(const std::string& name, const yaml::Node& node,
                    const std::vector<OverrideInput>& overrides, double robot_mass) {
  const Keys keys(name, node, overrides);
  Attachment a;
  a.name = name;
  a.node = node;
  a.to = keys.at("to").text();
  a.at = keys.at("at").vec2(dimension::length);
  if (const auto kind = keys.find("kind"))
    a.kind = static_cast<TailKind>(index_of(kTailKinds, kind->choice(kTailKinds)));

  if (const auto urdf = keys.find("urdf")) {
    node.only({"to", "at", "urdf", "kind"});
    if (a.kind == TailKind::drag && keys.find("kind"))
      throw keys.at("kind").error(
          "drag given with urdf; allowed: none, inertial; air on it is said in `drag`");
    a.urdf = urdf->text();
    return a;
  }
  if (a.kind != TailKind::none) read_tail(keys, node, robot_mass, a);
  return a;
}

}  // namespace

const std::vector<AttachKey>& attach_keys() {
  static const std::vector<AttachKey> keys = {
      {"to", "link that carries it"},
      {"at", "[x, z] of the pivot from that link's origin, along the robot's axes [m]"},
      {"kind", "drag, inertial (no air acts) or none (it isn't there); drag where absent"},
      {"length", "from the pivot to the tip [m]"},
      {"shaft", "of it, from the pivot: feels no air [m]"},
      {"scoop", "the rest, which does [m]; two of length, shaft and scoop are enough"},
      {"width", "of the scoop [m]; may be absent where no air acts"},
      {"mass", "of both [kg], or a share of the robot's own mass, 10 %"},
      {"scoop_mass", "of it, the scoop's [kg]; spread evenly over the length where absent"},
      {"range", "[lower, upper] of its joint, 0 is straight up [rad]; -90 to 90 deg where absent"},
      {"coefficient", "C_D [-]; 2 where absent, as measured on Minitaur's scoop"},
      {"density", "of air [kg/m^3]; 1.225 where absent"},
      {"motor", "keys as in motors, or the name of a joint that has one like it"},
      {"gear", "turns of the motor for one of the tail [-]; the motor's where absent"},
      {"urdf", "instead of a tail's own keys: a second URDF, its root fixed at the pivot"},
  };
  return keys;
}

std::vector<Attachment> read_attachments(const yaml::Node& robot,
                                         const std::vector<OverrideInput>& overrides,
                                         double robot_mass) {
  const auto section = robot.find("attach");
  std::vector<std::string> paths;
  if (section) {
    for (const auto& [name, node] : section->entries())
      for (const AttachKey& key : attach_keys())
        paths.push_back(fmt::format("attach.{}.{}", name, key.name));
  }
  for (const OverrideInput& o : overrides)
    if (std::find(paths.begin(), paths.end(), o.path) == paths.end())
      throw unknown_name(o.value, "key of what is attached", o.path, paths);

  std::vector<Attachment> attachments;
  if (!section) return attachments;
  for (const auto& [name, node] : section->entries())
    attachments.push_back(read_one(name, node, overrides, robot_mass));
  return attachments;
}

std::vector<std::string> attach_paths(const yaml::Node& robot) {
  std::vector<std::string> paths;
  const auto section = robot.find("attach");
  if (!section) return paths;
  for (const auto& [name, node] : section->entries())
    for (const auto& [key, value] : node.entries())
      paths.push_back(fmt::format("attach.{}.{} = {}", name, key, value.dump()));
  return paths;
}

}  // namespace jaculus::model
