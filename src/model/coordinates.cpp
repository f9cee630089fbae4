// Loops and generalised coordinates of robot.yaml: which joints are independent, and how they
// follow from the coordinates.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "jaculus/core/angle.h"
#include "model/sections.h"

namespace jaculus::model {
namespace {

bool is_dependent(const PlanarModel& model, int body) {
  return std::find(model.dependent.begin(), model.dependent.end(), body) != model.dependent.end();
}

bool is_ancestor(const PlanarModel& model, int ancestor, int body) {
  for (; body >= 0; body = model.bodies[body].parent) {
    if (body == ancestor) return true;
  }
  return false;
}

/// Pose (x, z, angle) of a body in the base's frame with all joints at zero.
Eigen::Vector3d pose_at_zero(const PlanarModel& model, int body) {
  if (body == 0) return Eigen::Vector3d::Zero();
  const PlanarBody& b = model.bodies[body];
  const Eigen::Vector3d p = pose_at_zero(model, b.parent);
  const double c = std::cos(p[2]);
  const double s = std::sin(p[2]);
  return {p[0] + c * b.origin.x() + s * b.origin.y(), p[1] - s * b.origin.x() + c * b.origin.y(),
          p[2] + b.angle_offset};
}

double cross(const Vec2& u, const Vec2& v) { return u.y() * v.x() - u.x() * v.y(); }

/// The branch that the URDF's zero lies on; an error where the loop is open or straight there.
double branch_at_zero(const yaml::Node& node, const PlanarModel& model, const PlanarLoop& loop) {
  const Eigen::Vector3d a = pose_at_zero(model, loop.body_a);
  const Eigen::Vector3d b = pose_at_zero(model, loop.body_b);
  const auto pin = [](const Eigen::Vector3d& pose, const Vec2& p) {
    const double c = std::cos(pose[2]);
    const double s = std::sin(pose[2]);
    return Vec2(pose[0] + c * p.x() + s * p.y(), pose[1] - s * p.x() + c * p.y());
  };

  const Vec2 pin_a = pin(a, loop.point_a);
  const double size = loop.point_a.norm() + loop.point_b.norm();
  if ((pin_a - pin(b, loop.point_b)).norm() > 1e-3 * size) {
    throw node.error(
        fmt::format("loop '{}' is open with all joints at zero, so its branch must be given; "
                    "allowed: branch: positive or "
                    "negative",
                    loop.name));
  }

  const double area = cross(b.head<2>() - a.head<2>(), pin_a - a.head<2>());
  if (std::abs(area) < 1e-3 * size * size) {
    throw node.error(
        fmt::format("loop '{}' is stretched with all joints at zero, so its branch must be given; "
                    "allowed: branch: positive "
                    "or negative",
                    loop.name));
  }

  return area > 0.0 ? 1.0 : -1.0;
}

/// One end of a loop: the link must be the very body that the dependent joint carries.
std::pair<int, Vec2> loop_end(const yaml::Node& node, const std::string& side,
                              const yaml::Node& joint_node, const Reduction& reduction,
                              const PlanarModel& model) {
  const yaml::Node link = node.at("link_" + side);
  const LinkPlace& place = link_place(link, link.text(), reduction);
  const std::string joint = joint_node.text();
  const int body = joint_body(joint_node, joint, model);

  if (place.body != body) {
    throw joint_node.error(fmt::format(
        "joint '{}' carries '{}', not '{}'; allowed: '{}', the joint at the root of link_{}", joint,
        model.bodies[body].name, link.text(), model.bodies[place.body].joint, side));
  }
  if (model.bodies[body].kind != JointKind::revolute) {
    throw joint_node.error(fmt::format("joint '{}' slides; allowed: joints that turn", joint));
  }
  if (is_dependent(model, body))
    throw joint_node.error(
        fmt::format("joint '{}' follows from another loop already; allowed: once", joint));

  const Vec2 point = node.at("point_" + side).vec2(dimension::length);
  const Vec2 on_body = place.position + turned(place.angle, point);
  if (!(on_body.norm() > 1e-9)) {
    throw node.at("point_" + side)
        .error(fmt::format("the pin lies on joint '{}' itself; allowed: away from it", joint));
  }

  return {body, on_body};
}

/// One row of `coordinates`: value = sum of coefficient * joint.
struct Combination {
  Coordinate coordinate;
  std::map<int, double> of;  ///< by body
  yaml::Node node;
  bool emitted = false;
};

std::vector<Combination> read_combinations(const yaml::Node& robot, const PlanarModel& model) {
  std::vector<Combination> list;
  const std::optional<yaml::Node> section = robot.find("coordinates");
  if (!section) return list;
  for (const auto& [name, node] : section->entries()) {
    node.only({"of", "range"});

    Combination c;
    c.node = node;
    c.coordinate.name = name;
    if (model.body_of_joint(name) >= 0)
      throw node.error(fmt::format("'{}' is the name of a joint; allowed: a new name", name));

    for (const auto& [joint, coefficient] : node.at("of").entries()) {
      const int body = joint_body(coefficient, joint, model);
      if (is_dependent(model, body)) {
        throw coefficient.error(
            fmt::format("joint '{}' follows from a loop; allowed: independent joints", joint));
      }
      c.of[body] = coefficient.number(dimension::none);
    }
    if (c.of.empty())
      throw node.at("of").error("no joint given; allowed: {joint: coefficient, ...}");

    const JointKind kind = model.bodies[c.of.begin()->first].kind;
    for (const auto& [body, coefficient] : c.of) {
      if (model.bodies[body].kind != kind) {
        throw node.at("of").error(
            "joints that turn and joints that slide given; allowed: all of one kind");
      }
    }
    c.coordinate.angular = kind == JointKind::revolute;
    if (const auto range = node.find("range")) {
      c.coordinate.range =
          range->bounds(c.coordinate.angular ? dimension::angle : dimension::length);
    }

    list.push_back(c);
  }
  return list;
}

/// The combinations that share joints with `first`, directly or through others.
std::vector<Combination*> group_of(Combination& first, std::vector<Combination>& all,
                                   std::set<int>& joints) {
  std::vector<Combination*> group;
  for (const auto& [body, coefficient] : first.of) joints.insert(body);
  for (std::size_t size = 0; size != joints.size();) {
    size = joints.size();
    for (Combination& c : all) {
      const bool shares = std::any_of(c.of.begin(), c.of.end(), [&](const auto& term) {
        return joints.count(term.first) != 0;
      });
      if (!shares) continue;
      for (const auto& [body, coefficient] : c.of) joints.insert(body);
    }
  }
  for (Combination& c : all) {
    if (joints.count(c.of.begin()->first) != 0) group.push_back(&c);
  }
  return group;
}

/// theta = C^-1 q for a group of coordinates q = C theta.
Matrix invert(const std::vector<Combination*>& group, const std::vector<int>& joints,
              const PlanarModel& model) {
  std::vector<std::string> names;
  for (const int body : joints) names.push_back(model.bodies[body].joint);

  const yaml::Node& node = group.front()->node;
  if (group.size() != joints.size()) {
    throw node.error(
        fmt::format("{} coordinate(s) for the {} joints {}; allowed: as many coordinates as joints",
                    group.size(), joints.size(), fmt::join(names, ", ")));
  }

  Matrix C = Matrix::Zero(group.size(), joints.size());
  for (int r = 0; r < count_of(group); ++r) {
    for (int j = 0; j < count_of(joints); ++j) {
      const auto term = group[r]->of.find(joints[j]);
      if (term != group[r]->of.end()) C(r, j) = term->second;
    }
  }

  const Eigen::FullPivLU<Matrix> lu(C);
  if (!lu.isInvertible() || !(lu.rcond() > 1e-9)) {
    throw node.error(fmt::format(
        "the coordinates of the joints {} depend on one another; allowed: independent combinations",
        fmt::join(names, ", ")));
  }
  return lu.inverse();
}

/// Appends columns for new coordinates.
Eigen::Index add_columns(PlanarModel& model, Eigen::Index count) {
  const Eigen::Index old = model.joint_map.cols();
  model.joint_map.conservativeResize(Eigen::NoChange, old + count);
  model.joint_map.rightCols(count).setZero();
  return old;
}

void add_group(Combination& first, std::vector<Combination>& all, PlanarModel& model) {
  std::set<int> joint_set;
  const std::vector<Combination*> group = group_of(first, all, joint_set);
  const std::vector<int> joints(joint_set.begin(), joint_set.end());
  const Matrix inverse = invert(group, joints, model);
  const Eigen::Index column = add_columns(model, inverse.cols());
  for (int j = 0; j < count_of(joints); ++j) {
    model.joint_map.block(joints[j], column, 1, inverse.cols()) = inverse.row(j);
  }
  for (Combination* c : group) {
    c->emitted = true;
    model.coordinates.push_back(c->coordinate);
  }
}

/// Ranges of robot.yaml take the place of the URDF's.
void read_ranges(const yaml::Node& robot, std::vector<Bounds>& joint_ranges,
                 std::vector<Coordinate>& base, const PlanarModel& model, const Absent& absent) {
  const std::optional<yaml::Node> section = robot.find("ranges");
  if (!section) return;
  for (const auto& [name, node] : section->entries()) {
    if (absent.count(name) != 0) continue;
    const auto found = std::find_if(base.begin(), base.end(),
                                    [&, key = name](const Coordinate& c) { return c.name == key; });
    if (found != base.end()) {
      found->range = node.bounds(found->angular ? dimension::angle : dimension::length);
      continue;
    }
    const int body = joint_body(node, name, model);
    const bool slides = model.bodies[body].kind == JointKind::prismatic;
    joint_ranges[body] = node.bounds(slides ? dimension::length : dimension::angle);
  }
}

void check_unique(const yaml::Node& robot, const PlanarModel& model) {
  std::set<std::string> seen;
  for (const Coordinate& c : model.coordinates) {
    if (!seen.insert(c.name).second)
      throw robot.error(
          fmt::format("two coordinates are called '{}'; allowed: names that differ", c.name));
  }
}

}  // namespace

void read_loops(const yaml::Node& robot, const Reduction& reduction, PlanarModel& model) {
  const std::optional<yaml::Node> section = robot.find("loops");
  if (!section) return;
  for (const auto& [name, node] : section->entries()) {
    node.only({"link_a", "point_a", "link_b", "point_b", "dependent", "branch"});
    const std::vector<yaml::Node> joints = node.at("dependent").items();
    if (joints.size() != 2) {
      throw node.at("dependent")
          .error(
              fmt::format("{} joints given; allowed: two, those at the roots of link_a and link_b",
                          joints.size()));
    }

    PlanarLoop loop;
    loop.name = name;
    std::tie(loop.body_a, loop.point_a) = loop_end(node, "a", joints[0], reduction, model);
    std::tie(loop.body_b, loop.point_b) = loop_end(node, "b", joints[1], reduction, model);

    if (is_ancestor(model, loop.body_a, loop.body_b) ||
        is_ancestor(model, loop.body_b, loop.body_a)) {
      throw node.error(
          "link_a and link_b lie on one branch of the tree; allowed: links of two branches");
    }
    if (model.bodies[loop.body_a].count != model.bodies[loop.body_b].count) {
      throw node.error(
          "one of link_a and link_b is lumped and the other is not; allowed: both or neither");
    }

    if (const auto branch = node.find("branch")) {
      loop.branch = branch->choice({"positive", "negative"}) == "positive" ? 1.0 : -1.0;
    } else {
      loop.branch = branch_at_zero(node, model, loop);
    }

    model.loops.push_back(loop);
    model.dependent.push_back(loop.body_a);
    model.dependent.push_back(loop.body_b);
  }
}

void read_coordinates(const yaml::Node& robot, const Reduction& reduction, const Absent& absent,
                      PlanarModel& model) {
  const auto bodies = std::ssize(model.bodies);
  if (model.base_free[0]) model.coordinates.push_back({"x", false, {}});
  if (model.base_free[1]) model.coordinates.push_back({"z", false, {}});
  if (model.base_free[2]) model.coordinates.push_back({"pitch", true, {}});
  std::vector<Bounds> ranges = reduction.ranges;
  read_ranges(robot, ranges, model.coordinates, model, absent);
  model.joint_map = Matrix::Zero(bodies, model.size());
  model.joint_offset = Vector::Zero(bodies);

  std::vector<Combination> combinations = read_combinations(robot, model);
  for (int b = 1; b < bodies; ++b) {
    const PlanarBody& body = model.bodies[b];
    const bool dependent = is_dependent(model, b);
    const auto named = std::find_if(combinations.begin(), combinations.end(),
                                    [&](const Combination& c) { return c.of.count(b) != 0; });
    if (!dependent && named == combinations.end()) {
      const Eigen::Index column = add_columns(model, 1);
      model.joint_map(b, column) = 1.0;
      model.coordinates.push_back({body.joint, body.kind == JointKind::revolute, ranges[b]});
      continue;
    }
    if (!dependent && !named->emitted) add_group(*named, combinations, model);
    if (std::isfinite(ranges[b].lower) || std::isfinite(ranges[b].upper)) {
      model.joint_ranges.push_back({body.joint, b, ranges[b]});
    }
  }
  check_unique(robot, model);
}

}  // namespace jaculus::model
