#include "model/sections.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "jaculus/core/angle.h"
#include "model/fields.h"

namespace jaculus::model {
namespace {

constexpr std::array<const char*, 3> kBaseNames = {"x", "z", "pitch"};

template <typename Element>
std::vector<std::string> names_of(const std::vector<Element>& elements) {
  std::vector<std::string> names;
  for (const Element& element : elements) names.push_back(element.name);
  return names;
}

Vec2 on_body(const LinkPlace& place, const Vec2& point) {
  return place.position + turned(place.angle, point);
}

}  // namespace

InputError unknown_name(const yaml::Node& node, const std::string& what, const std::string& given,
                        const std::vector<std::string>& known) {
  return node.error(
      fmt::format("unknown {} '{}'{}; allowed: {}", what, given, yaml::did_you_mean(given, known),
                  known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))));
}

int joint_body(const yaml::Node& node, const std::string& joint, const PlanarModel& model) {
  const int body = model.body_of_joint(joint);
  if (body >= 0) return body;
  std::vector<std::string> known;
  for (std::size_t b = 1; b < model.bodies.size(); ++b) known.push_back(model.bodies[b].joint);
  throw unknown_name(node, "joint", joint, known);
}

const LinkPlace& link_place(const yaml::Node& node, const std::string& link,
                            const Reduction& reduction) {
  const auto found = reduction.links.find(link);
  if (found == reduction.links.end()) {
    std::vector<std::string> known;
    for (const auto& [name, place] : reduction.links) known.push_back(name);
    throw unknown_name(node, "link", link, known);
  }
  if (!found->second.in_plane) {
    throw node.error(fmt::format(
        "link '{}' is turned out of the sagittal plane; allowed: a link whose y axis is the root's",
        link));
  }
  return found->second;
}

void read_base(const yaml::Node& robot, PlanarModel& model) {
  const yaml::Node base = robot.at("base");
  if (!base.is_map()) {
    model.base_free.fill(base.choice({"floating", "fixed"}) == "floating");
    return;
  }

  base.only({"free", "pose"});
  model.base_free.fill(false);
  for (const yaml::Node& node : base.at("free").items()) {
    const std::string axis = node.choice({"x", "z", "pitch"});
    const auto index = axis == "x" ? 0 : axis == "z" ? 1 : 2;
    if (model.base_free[index])
      throw node.error(fmt::format("'{}' given twice; allowed: once", axis));
    model.base_free[index] = true;
  }

  const std::optional<yaml::Node> pose = base.find("pose");
  if (!pose) return;
  pose->only({"x", "z", "pitch"});
  for (std::size_t i = 0; i < 3; ++i) {
    const std::optional<yaml::Node> value = pose->find(kBaseNames[i]);
    if (!value) continue;
    if (model.base_free[i])
      throw value->error(
          fmt::format("{} is free, so it has no fixed value; allowed: without it", kBaseNames[i]));
    model.base_pose[i] = value->number(i == 2 ? dimension::angle : dimension::length);
  }
}

std::vector<PairSpec> read_pairs(const yaml::Node& robot, const std::string& kind,
                                 const SpatialTree& tree, Absent& absent) {
  std::vector<PairSpec> pairs;
  const std::optional<yaml::Node> all = robot.find("pairs");
  if (!all) return pairs;
  all->only({"joints", "links"});
  const std::optional<yaml::Node> section = all->find(kind);
  if (!section) return pairs;

  const bool joints = kind == "joints";
  const std::vector<std::string> known = joints ? names_of(tree.joints) : names_of(tree.links);
  std::set<std::string> used;
  for (const auto& [name, node] : section->entries()) {
    const std::vector<yaml::Node> sides = node.items();
    if (sides.size() != 2)
      throw node.error(fmt::format("{} names given; allowed: two, [left, right]", sides.size()));
    if (absent.count(sides[0].text()) != 0 && absent.count(sides[1].text()) != 0) {
      absent.insert(name);
      continue;
    }
    for (const yaml::Node& side : sides) {
      const std::string given = side.text();
      if (std::find(known.begin(), known.end(), given) == known.end()) {
        throw unknown_name(side, joints ? "joint" : "link", given, known);
      }
      if (!used.insert(given).second)
        throw side.error(fmt::format("'{}' is in two pairs; allowed: in one", given));
      if (joints && tree.joints[tree.joint_index(given)].kind == SpatialJointKind::fixed) {
        throw side.error(fmt::format("joint '{}' is fixed; allowed: joints that move", given));
      }
    }
    pairs.push_back({name, sides[0].text(), sides[1].text(), node});
  }

  for (const PairSpec& pair : pairs) {
    const bool taken = std::find(known.begin(), known.end(), pair.name) != known.end();
    if (taken && pair.name != pair.left && pair.name != pair.right) {
      throw pair.node.error(fmt::format(
          "'{}' is the name of another one in the URDF; allowed: a new name", pair.name));
    }
  }
  return pairs;
}

std::vector<HeldJoint> read_held(const yaml::Node& robot, const SpatialTree& tree,
                                 const std::vector<PairSpec>& pairs, const Absent& absent) {
  std::vector<HeldJoint> held;
  const std::optional<yaml::Node> section = robot.find("fixed_joints");
  if (!section) return held;
  for (const auto& [name, node] : section->entries()) {
    if (absent.count(name) != 0) continue;
    const int index = tree.joint_index(name);
    if (index < 0) throw unknown_name(node, "joint", name, names_of(tree.joints));

    const SpatialJoint& joint = tree.joints[index];
    if (joint.kind == SpatialJointKind::fixed)
      throw node.error(fmt::format("joint '{}' is fixed already; allowed: joints that move", name));
    for (const PairSpec& pair : pairs) {
      if (pair.left == name || pair.right == name) {
        throw node.error(fmt::format("joint '{}' is in the pair '{}'; allowed: joints in no pair",
                                     name, pair.name));
      }
    }

    const bool slides = joint.kind == SpatialJointKind::prismatic;
    const double value = node.number(slides ? dimension::length : dimension::angle, joint.range);
    held.push_back({name, value, slides});
  }
  return held;
}

std::vector<PlanarPoint> read_points(const yaml::Node& robot, const std::string& key,
                                     const Reduction& reduction, const PlanarModel& model,
                                     const Absent& absent) {
  std::vector<PlanarPoint> points;
  const std::optional<yaml::Node> section = robot.find(key);
  if (!section) return points;
  for (const auto& [name, node] : section->entries()) {
    node.only({"link", "point"});
    const yaml::Node link = node.at("link");
    if (absent.count(link.text()) != 0) continue;
    const LinkPlace& place = link_place(link, link.text(), reduction);
    PlanarPoint point;
    point.name = name;
    point.body = place.body;
    point.position = on_body(place, node.at("point").vec2(dimension::length));
    point.count = model.bodies[place.body].count;
    points.push_back(point);
  }
  return points;
}

std::map<std::string, double> read_rest_pose(const yaml::Node& robot, const PlanarModel& model,
                                             const Absent& absent) {
  std::map<std::string, double> pose;
  const std::optional<yaml::Node> section = robot.find("rest_pose");
  if (!section) return pose;

  std::vector<std::string> known;
  for (const PlanarMotor& motor : model.motors) known.push_back(motor.joint);

  for (const auto& [name, node] : section->entries()) {
    if (absent.count(name) != 0) continue;
    const int motor = model.motor_index(name);
    if (motor < 0) throw unknown_name(node, "joint with a motor", name, known);

    const int body = model.motors[motor].body;
    const bool slides = model.bodies[body].kind == JointKind::prismatic;
    pose[name] = node.number(slides ? dimension::length : dimension::angle);
  }
  return pose;
}

void read_drags(const yaml::Node& robot, const Reduction& reduction, const Absent& absent,
                PlanarModel& model) {
  const std::optional<yaml::Node> section = robot.find("drag");
  if (!section) return;
  for (const auto& [name, node] : section->entries()) {
    std::vector<std::string> keys = {"link", "direction"};
    for (const Key<PlanarDrag>& key : drag_keys()) keys.emplace_back(key.name);
    node.only(keys);

    PlanarDrag drag;
    drag.name = name;
    const yaml::Node link = node.at("link");
    if (absent.count(link.text()) != 0) continue;
    const LinkPlace& place = link_place(link, link.text(), reduction);
    if (place.body == 0 || place.position.norm() > 1e-9) {
      throw link.error(fmt::format(
          "link '{}' does not begin at a joint; allowed: a link that a moving joint carries",
          link.text()));
    }

    drag.body = place.body;
    const Vec2 direction = node.at("direction").vec2(dimension::none);
    if (!(direction.norm() > 1e-6))
      throw node.at("direction").error("a direction of length 0 given; allowed: any other");
    drag.direction = on_body(place, direction.normalized()) - place.position;

    for (const Field& field : drag_fields(drag))
      if (field.required || node.has(field.key())) field.read(node.at(field.key()));
    model.drags.push_back(drag);
  }
}

namespace {

/// Where a drag's key is said: by an override of it, else by one of another key of this drag, which
/// may ask for it, else in robot.yaml.
yaml::Node place_of_drag(const yaml::Node& robot, const std::vector<OverrideInput>& overrides,
                         const PlanarDrag& drag, const std::string& key) {
  std::vector<std::string> keys = {key};
  for (const Key<PlanarDrag>& other : drag_keys()) keys.emplace_back(other.name);
  for (const std::string& one : keys)
    for (const OverrideInput& o : overrides)
      if (matches(o.path, drag.name + ".drag." + one)) return o.value;
  const auto drags = robot.find("drag");
  const bool own = drags && drags->has(drag.name);
  return (own ? *drags : robot.at("attach")).at(drag.name);
}

}  // namespace

void check_drags(const yaml::Node& robot, const std::vector<OverrideInput>& overrides,
                 const PlanarModel& model) {
  for (const PlanarDrag& drag : model.drags) {
    const auto refuse = [&](const std::string& key, const std::string& what) {
      return place_of_drag(robot, overrides, drag, key)
          .error(fmt::format("{}.drag.{}: {}", drag.name, key, what));
    };

    const bool strip = drag.kind == DragKind::distributed || drag.kind == DragKind::rotation;
    const std::string kind = drag_kinds()[static_cast<std::size_t>(drag.kind)];
    if (strip && !(drag.width > 0.0))
      throw refuse("width", "must be given and above 0 m where kind is " + kind);
    if (strip && !(drag.end > drag.start)) {
      throw refuse("end",
                   fmt::format("{:.10g} m given with start {:.10g} m; allowed: end above start",
                               drag.end, drag.start));
    }

    if (drag.kind == DragKind::point && !(drag.point_distance > 0.0)) {
      throw refuse("point_distance", "must be given and above 0 m where kind is point");
    }
    if (drag.kind == DragKind::point && !(drag.point_area > 0.0)) {
      throw refuse("point_area", "must be given and above 0 m^2 where kind is point");
    }
  }
}

}  // namespace jaculus::model
