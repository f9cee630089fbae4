#include "testbed/robot_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "jaculus/core/yaml.h"
#include "jaculus/model/robot.h"
#include "jaculus/testbed/robot_notes.h"
#include "model/propose/draft.h"
#include "model/reduce.h"
#include "testbed/limbs.h"

namespace jaculus::testbed {
namespace {

using Sides = std::map<std::string, std::vector<std::string>>;

/// pairs.joints or pairs.links: planar name to the names in space.
Sides read_sides(const yaml::Node& robot, const std::string& kind) {
  Sides sides;
  const auto pairs = robot.find("pairs");
  if (!pairs) return sides;
  const auto section = pairs->find(kind);
  if (!section) return sides;
  for (const auto& [name, node] : section->entries()) sides[name] = node.texts();
  return sides;
}

std::vector<std::string> sides_of(const Sides& sides, const std::string& name) {
  const auto found = sides.find(name);
  return found == sides.end() ? std::vector<std::string>{name} : found->second;
}

std::vector<int> fixed_to(const model::SpatialTree& tree, int parent) {
  std::vector<int> children;
  for (const model::SpatialJoint& joint : tree.joints)
    if (joint.parent == parent && joint.kind == model::SpatialJointKind::fixed)
      children.push_back(joint.child);
  return children;
}

/// Whether names are those of a left and a right one.
bool are_sides(const std::string& a, const std::string& b) {
  return a != b && model::other_side(model::other_side(b)) == model::other_side(a);
}

/// Takes what pairs by name out of both lists.
std::vector<std::array<int, 2>> by_name(const model::SpatialTree& tree, std::vector<int>& left,
                                        std::vector<int>& right) {
  std::vector<std::array<int, 2>> pairs;
  std::erase_if(left, [&](int l) {
    const auto found = std::find_if(right.begin(), right.end(), [&](int r) {
      return are_sides(tree.links[l].name, tree.links[r].name);
    });
    if (found == right.end()) return false;
    pairs.push_back({l, *found});
    right.erase(found);
    return true;
  });
  return pairs;
}

/// Links of a pair of joints are a pair too, and so is what is fixed to them, for imports state
/// pairs of joints alone: by names that differ in their side alone; one that is left on each side
/// with the other; more of them in the file's order. What isn't by name, and what has no other
/// side, is a line of `notes`.
void pair_links(const model::SpatialTree& tree, int left, int right, Sides& links,
                std::vector<std::string>& notes) {
  const std::string& name = tree.links[left].name;
  const auto has = [&](const auto& pair) { return pair.second.front() == name; };
  if (std::none_of(links.begin(), links.end(), has)) links[name] = {name, tree.links[right].name};

  std::vector<int> a = fixed_to(tree, left), b = fixed_to(tree, right);
  std::vector<std::array<int, 2>> pairs = by_name(tree, a, b);
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    pairs.push_back({a[i], b[i]});
    notes.push_back(fmt::format(
        "links '{}' and '{}' are taken as left and right of one, {}: their names don't say so",
        tree.links[a[i]].name, tree.links[b[i]].name,
        a.size() == 1 && b.size() == 1 ? "what is left of both sides" : "in the file's order"));
  }
  for (const std::vector<int>* side : {&a, &b}) {
    for (std::size_t i = std::min(a.size(), b.size()); i < side->size(); ++i)
      notes.push_back(fmt::format("link '{}' has none on the other side: it counts by itself",
                                  tree.links[(*side)[i]].name));
  }
  for (const auto& [l, r] : pairs) pair_links(tree, l, r, links, notes);
}

model::Vec3 in_space(const Vec2& point) { return {point.x(), 0.0, point.y()}; }

void read_pins(const yaml::Node& robot, const Sides& joints, const Sides& links,
               const model::PlanarModel& planar, RobotFiles& files) {
  const auto section = robot.find("loops");
  if (!section) return;
  std::size_t index = 0;
  for (const auto& [name, node] : section->entries()) {
    const auto a = sides_of(links, node.at("link_a").text()),
               b = sides_of(links, node.at("link_b").text());
    const std::vector<std::string> dependent = node.at("dependent").texts();
    const auto joint_a = sides_of(joints, dependent.at(0)),
               joint_b = sides_of(joints, dependent.at(1));
    const model::PlanarLoop& loop = planar.loops.at(index++);
    for (std::size_t side = 0; side < a.size(); ++side) {
      files.pins.push_back({a[side], b.at(side), in_space(loop.point_a), in_space(loop.point_b),
                            joint_a.at(side), joint_b.at(side), loop.branch});
    }
  }
}

void read_toes(const yaml::Node& robot, const Sides& links, RobotFiles& files) {
  const auto section = robot.find("feet");
  if (!section) return;
  for (const auto& [name, node] : section->entries()) {
    const model::Vec3 point = in_space(node.at("point").vec2(dimension::length));
    for (const std::string& link : sides_of(links, node.at("link").text()))
      files.toes.push_back({name, link, point});
  }
}

/// The testbed's world is the sagittal plane, so every axis must be +-y, or lie in the plane where
/// a joint slides.
void check_axes(const model::SpatialTree& tree) {
  for (const model::SpatialJoint& joint : tree.joints) {
    const bool turns = joint.kind == model::SpatialJointKind::revolute;
    const bool slides = joint.kind == model::SpatialJointKind::prismatic;
    const double along_y = std::abs(joint.axis.y());
    if ((turns && along_y < 1.0 - 1e-9) || (slides && along_y > 1e-9)) {
      throw InputError(fmt::format(
          "{}:{}: joint '{}': axis leaves the sagittal plane; allowed on the testbed: turning "
          "about y, sliding in x-z",
          tree.file.string(), joint.line, joint.name));
    }
  }
}

/// Links are drawn in the plane by their URDF frames, left and right alike.
void check_frames(const model::SpatialTree& tree, const Sides& joints) {
  for (const model::SpatialLink& link : tree.links) {
    if (link.R_BL(1, 1) > 1.0 - 1e-9) continue;
    throw InputError(fmt::format(
        "{}:{}: link '{}': its frame is turned out of the sagittal plane; allowed on the testbed: "
        "links whose y axis is the root's",
        tree.file.string(), link.line, link.name));
  }
  for (const auto& [name, sides] : joints) {
    const model::SpatialJoint& left = tree.joints.at(tree.joint_index(sides.at(0)));
    const model::SpatialJoint& right = tree.joints.at(tree.joint_index(sides.at(1)));
    if (left.axis.y() * right.axis.y() >= 0.0) continue;
    throw InputError(fmt::format(
        "{}:{}: joints '{}' and '{}' turn opposite ways; allowed on the testbed: pairs that turn "
        "the same way",
        tree.file.string(), right.line, left.name, right.name));
  }
}

/// rest_pose, which the model's reader has checked.
std::map<std::string, double> read_rest(const yaml::Node& robot, const model::PlanarModel& planar) {
  std::map<std::string, double> rest;
  const auto section = robot.find("rest_pose");
  if (!section) return rest;
  for (const auto& [name, node] : section->entries()) {
    const bool turns = planar.bodies[planar.body_of_joint(name)].kind == model::JointKind::revolute;
    rest[name] = node.number(turns ? dimension::angle : dimension::length);
  }
  return rest;
}

/// Says where every motor and toe is; one tail at most.
void set_limbs(const yaml::Node& robot, RobotFiles& files) {
  for (const std::string& link : files.drag_links) {
    if (files.tree.link_index(link) >= 0) continue;
    throw robot.at("drag").error(
        fmt::format("link '{}' stands for a pair; allowed on the testbed: drag on one link", link));
  }

  const std::vector<Limb> limbs =
      limbs_of_links(files.tree, files.drag_links, files.toes, files.pins);
  const model::SpatialTree& tree = files.tree;
  for (Toe& toe : files.toes) toe.limb = limbs[tree.link_index(toe.link)];
  for (Drive& drive : files.drives)
    drive.limb = limbs[tree.joints[tree.joint_index(drive.joint)].child];
}

}  // namespace

std::vector<std::string> RobotFiles::motors_of(Limb limb) const {
  std::vector<std::string> names;
  for (const Drive& drive : drives) {
    const bool known = std::find(names.begin(), names.end(), drive.planar) != names.end();
    if (drive.limb == limb && !known) names.push_back(drive.planar);
  }
  return names;
}

std::vector<int> RobotFiles::sides_of(const std::string& planar) const {
  std::vector<int> sides;
  for (int i = 0; i < count_of(drives); ++i)
    if (drives[i].planar == planar) sides.push_back(i);
  return sides;
}

const model::PlanarMotor* RobotFiles::motor_of(const std::string& planar) const {
  const std::vector<int> sides = sides_of(planar);
  return sides.empty() ? nullptr : &drives[sides.front()].motor;
}

const model::SpatialJoint& RobotFiles::joint_of(const std::string& planar) const {
  const std::vector<int> sides = sides_of(planar);
  const std::string& name = sides.empty() ? planar : drives[sides.front()].joint;
  return tree.joints.at(tree.joint_index(name));
}

double RobotFiles::rest_of(const std::string& planar) const {
  const auto found = rest.find(planar);
  return found == rest.end() ? 0.0 : found->second;
}

namespace {

RobotFiles read_files(const std::filesystem::path& folder, std::vector<std::string>& notes) {
  const model::Robot robot = model::read_robot(folder);
  const yaml::Node node = yaml::Node::load(folder / "robot.yaml");
  RobotFiles files;
  files.name = robot.name;
  for (const char* key : {"axes", "base_link"}) {
    if (const auto placed = node.find(key))
      throw placed->error(fmt::format(
          "{}; allowed on the testbed: a URDF whose root is the base, x forward, z up", key));
  }

  files.tree = model::hold_joints(model::read_tree(folder), robot.planar.held);
  check_axes(files.tree);
  const auto& free = robot.planar.base_free;
  files.floating = free[0] && free[1] && free[2];
  if (!files.floating && (free[0] || free[1] || free[2])) {
    throw node.at("base").error(
        "a base that moves in part; allowed on the testbed: floating, fixed");
  }

  files.tolerances = robot.tolerances;
  files.gravity = robot.planar.gravity;
  files.friction = robot.planar.friction;
  const Sides joints = read_sides(node, "joints");
  Sides links = read_sides(node, "links");
  check_frames(files.tree, joints);
  for (const auto& [name, sides] : joints) {
    const auto child = [&](const std::string& joint) {
      return files.tree.joints.at(files.tree.joint_index(joint)).child;
    };
    pair_links(files.tree, child(sides.at(0)), child(sides.at(1)), links, notes);
  }
  for (const auto& [name, sides] : links) {
    for (const std::string& side : sides) files.link_pairs[side] = sides.front();
  }
  read_pins(node, joints, links, robot.planar, files);
  read_toes(node, links, files);
  for (const model::PlanarMotor& motor : robot.planar.motors) {
    files.planar_motors.push_back(motor.joint);
    for (const std::string& joint : sides_of(joints, motor.joint))
      files.drives.push_back({joint, motor.joint, motor});
  }

  files.drags = robot.planar.drags;
  const auto section = node.find("drag");
  for (const model::PlanarDrag& drag : files.drags) {
    const bool own = section && section->has(drag.name);
    // an attached tail's link bears its name
    files.drag_links.push_back(own ? section->at(drag.name).at("link").text() : drag.name);
  }
  files.rest = read_rest(node, robot.planar);
  set_limbs(node, files);
  return files;
}

}  // namespace

RobotFiles read_robot_files(const std::filesystem::path& folder) {
  std::vector<std::string> notes;
  return read_files(folder, notes);
}

std::vector<std::string> notes_on_robot(const std::filesystem::path& robot_folder) {
  std::vector<std::string> notes;
  (void)read_files(robot_folder, notes);
  return notes;
}

}  // namespace jaculus::testbed
