// What is attached, put on the tree in space and into the planar model.

#include "model/attach.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "model/sections.h"

namespace jaculus::model {
namespace {

InputError taken(const Attachment& a, const std::string& name) {
  return a.node.error(
      fmt::format("'{}' is a link or joint of the robot already; allowed: a new name", name));
}

/// The link that carries it, and the place of its pivot in that link's frame.
int carrier(const Attachment& a, const SpatialTree& tree) {
  const int link = tree.link_index(a.to);
  if (link >= 0) return link;
  std::vector<std::string> known;
  for (const SpatialLink& l : tree.links) known.push_back(l.name);
  throw unknown_name(a.node.at("to"), "link", a.to, known);
}

/// A joint at the pivot, in the plane, whose frame lies as the robot's with all joints at zero.
SpatialJoint pivot(const Attachment& a, int parent, const SpatialTree& tree) {
  const SpatialLink& link = tree.links[parent];
  SpatialJoint joint;
  joint.name = a.name;
  joint.line = a.node.line();
  joint.parent = parent;
  joint.origin = link.R_BL.transpose() * Vec3(a.at.x(), -link.p_BL.y(), a.at.y());
  joint.rotation = link.R_BL.transpose();
  joint.axis = Vec3::UnitY();
  joint.attached = true;
  return joint;
}

void refuse_taken(const Attachment& a, const std::string& name, const SpatialTree& tree) {
  if (tree.link_index(name) >= 0 || tree.joint_index(name) >= 0) throw taken(a, name);
}

void attach_tail(const Attachment& a, SpatialTree& tree) {
  refuse_taken(a, a.name, tree);
  SpatialJoint joint = pivot(a, carrier(a, tree), tree);
  joint.kind = SpatialJointKind::revolute;
  joint.range = a.range;
  joint.child = count_of(tree.links);

  SpatialLink link = tail_link(a);
  link.joint = count_of(tree.joints);
  tree.links.push_back(link);
  tree.joints.push_back(joint);
}

SpatialTree read_part(const Attachment& a, Reading reading) {
  const std::filesystem::path file = a.node.file().parent_path() / a.urdf;
  if (!std::filesystem::is_regular_file(file)) {
    throw a.node.at("urdf").error(
        fmt::format("file '{}' not found; allowed: a URDF, relative to this file", file.string()));
  }
  return read_urdf(file, reading);
}

void attach_urdf(const Attachment& a, Reading reading, SpatialTree& tree) {
  const SpatialTree part = read_part(a, reading);
  refuse_taken(a, a.name, tree);
  SpatialJoint joint = pivot(a, carrier(a, tree), tree);
  const int links = count_of(tree.links), joints = count_of(tree.joints) + 1;
  joint.child = links + part.root;
  tree.joints.push_back(joint);

  for (SpatialLink link : part.links) {
    refuse_taken(a, link.name, tree);
    link.joint = link.joint < 0 ? joints - 1 : link.joint + joints;
    tree.links.push_back(link);
  }
  for (SpatialJoint moved : part.joints) {
    refuse_taken(a, moved.name, tree);
    moved.parent += links;
    moved.child += links;
    moved.attached = true;
    tree.joints.push_back(moved);
  }
  tree.notes.insert(tree.notes.end(), part.notes.begin(), part.notes.end());
}

/// The motor of the joint that is named, or the one that is written there.
PlanarMotor attached_motor(const Attachment& a, const PlanarModel& model) {
  PlanarMotor motor;
  if (a.motor.is_map()) {
    motor = read_motor(a.name, a.motor, model);
  } else {
    const int like = model.motor_index(a.motor.text());
    if (like < 0) {
      std::vector<std::string> known;
      for (const PlanarMotor& m : model.motors) known.push_back(m.joint);
      throw unknown_name(a.motor, "joint with a motor", a.motor.text(), known);
    }
    motor = model.motors[like];
    if (model.slides(motor))
      throw a.motor.error(
          fmt::format("joint '{}' slides; allowed: a joint that turns", a.motor.text()));
  }

  motor.joint = a.name;
  motor.body = model.body_of_joint(a.name);
  motor.count = model.bodies[motor.body].count;
  if (a.gear) motor.gear = *a.gear;
  return motor;
}

PlanarDrag attached_drag(const Attachment& a, int body) {
  PlanarDrag drag;
  drag.name = a.name;
  drag.body = body;
  drag.kind = a.kind == TailKind::drag ? DragKind::distributed : DragKind::none;
  drag.density = a.density;
  drag.coefficient = a.coefficient;
  drag.width = a.width;
  drag.start = a.length - a.scoop;
  drag.end = a.length;
  drag.point_distance = a.length - 0.5 * a.scoop;
  drag.point_area = a.scoop * a.width;
  return drag;
}

/// What another section of robot.yaml says of the same thing.
void refuse_second_parts(const Attachment& a, const PlanarModel& model) {
  const auto named = [&](const auto& list, const std::string& name) {
    return std::any_of(list.begin(), list.end(), [&](const auto& e) { return e.name == name; });
  };
  const auto refuse = [&](const char* section, const std::string& name) {
    return a.node.error(fmt::format(
        "'{}' is in {} as well; allowed: in one of the two, an attached tail brings its own", name,
        section));
  };
  if (model.motor_index(a.name) >= 0) throw refuse("motors", a.name);
  if (named(model.drags, a.name)) throw refuse("drag", a.name);
  if (named(model.points, a.name + "_tip")) throw refuse("points", a.name + "_tip");
}

/// A rod and a plate, for eyes alone: a tail has no thickness.
std::vector<SpatialShape> looks(const Attachment& tail) {
  constexpr double kThickness = 0.01;  // of the length
  const double shaft = tail.length - tail.scoop, thin = 0.5 * kThickness * tail.length;
  std::vector<SpatialShape> shapes;
  SpatialShape shape;
  shape.touches = false;
  if (shaft > 0.0) {
    shape.kind = ShapeKind::cylinder;
    shape.size = Vec3(thin, thin, 0.5 * shaft);
    shape.position = Vec3(0.0, 0.0, 0.5 * shaft);
    shapes.push_back(shape);
  }
  if (tail.scoop > 0.0) {
    shape.kind = ShapeKind::box;
    shape.size = Vec3(thin, std::max(thin, 0.5 * tail.width), 0.5 * tail.scoop);
    shape.position = Vec3(0.0, 0.0, shaft + 0.5 * tail.scoop);
    shapes.push_back(shape);
  }
  return shapes;
}

}  // namespace

SpatialLink tail_link(const Attachment& tail) {
  const double p = tail.scoop, s = tail.length - p;
  const double m_p = tail.scoop_mass, m_s = tail.mass - m_p;
  const double c = (m_s * s / 2.0 + m_p * (s + p / 2.0)) / tail.mass;
  const auto about = [c](double mass, double size, double middle) {
    return mass * (size * size / 12.0 + (middle - c) * (middle - c));
  };
  const double pitch = about(m_s, s, s / 2.0) + about(m_p, p, s + p / 2.0);
  const double across = m_p * tail.width * tail.width / 12.0;

  SpatialLink link;
  link.name = tail.name;
  link.line = tail.node.line();
  link.mass = tail.mass;
  link.com = Vec3(0.0, 0.0, c);
  link.inertia = Vec3(pitch + across, pitch, across).asDiagonal();
  link.shapes = looks(tail);
  return link;
}

Absent remove_absent(Reading reading, std::vector<Attachment>& attachments) {
  Absent names;
  for (const Attachment& a : attachments) {
    if (a.kind != TailKind::none) continue;
    names.insert(a.name);
    if (a.urdf.empty()) continue;
    const SpatialTree part = read_part(a, reading);
    for (const SpatialLink& link : part.links) names.insert(link.name);
    for (const SpatialJoint& joint : part.joints) names.insert(joint.name);
  }

  std::erase_if(attachments, [](const Attachment& a) { return a.kind == TailKind::none; });
  return names;
}

void attach(const std::vector<Attachment>& attachments, Reading reading, SpatialTree& tree) {
  for (const Attachment& a : attachments) {
    if (a.urdf.empty()) {
      attach_tail(a, tree);
    } else {
      attach_urdf(a, reading, tree);
    }
  }
  if (!attachments.empty()) place_links(tree);
}

void check_carriers(const std::vector<Attachment>& attachments, const std::vector<PairSpec>& pairs,
                    const SpatialTree& tree) {
  for (const Attachment& a : attachments) {
    for (int l = tree.link_index(a.to); tree.links[l].joint >= 0;
         l = tree.joints[tree.links[l].joint].parent) {
      const std::string& joint = tree.joints[tree.links[l].joint].name;
      for (const PairSpec& pair : pairs) {
        if (joint != pair.left && joint != pair.right) continue;
        throw a.node.at("to").error(
            fmt::format("'{}' is one side of the pair '{}'; allowed: a link that is there once",
                        a.to, pair.name));
      }
    }
  }
}

void add_attached_parts(const std::vector<Attachment>& attachments, PlanarModel& model) {
  for (const Attachment& a : attachments) {
    if (!a.urdf.empty()) continue;
    refuse_second_parts(a, model);
    const int body = model.body_of_joint(a.name);
    model.motors.push_back(attached_motor(a, model));
    model.points.push_back({a.name + "_tip", body, {0.0, a.length}, 1});
    model.drags.push_back(attached_drag(a, body));
  }
}

std::string attached_note(const Attachment& a) {
  if (!a.urdf.empty()) return fmt::format("'{}' is attached to '{}' from {}", a.name, a.to, a.urdf);
  const SpatialLink link = tail_link(a);
  const std::string air =
      a.kind == TailKind::inertial
          ? "no air acts on it"
          : fmt::format("drag on {:.4g} m x {:.4g} m, C_D {:.4g}", a.scoop, a.width, a.coefficient);
  return fmt::format(
      "'{}' is attached to '{}': {:.4g} kg on {:.4g} m, centre of mass at {:.4g} m, pitch inertia "
      "{:.4g} kg m^2 about it, {}",
      a.name, a.to, a.mass, a.length, link.com.z(), link.inertia(1, 1), air);
}

}  // namespace jaculus::model
