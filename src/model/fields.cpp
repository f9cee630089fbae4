#include "model/fields.h"

#include <fmt/format.h>

namespace jaculus {
namespace {

// Where zero is impossible but any positive number is fine, this stands for "more than 0".
constexpr double kTiny = 1e-12;
constexpr Bounds kPositive{kTiny, kInfinity};
constexpr Bounds kNotNegative{0.0, kInfinity};

}  // namespace

const std::vector<std::string>& drag_kinds() {
  static const std::vector<std::string> names = {"none", "distributed", "point", "rotation"};  // in DragKind's order
  return names;
}

const std::vector<Key>& motor_keys() {
  static const std::vector<Key> keys = {
      {"torque_constant", "N m/A", "k_t before the gear, equally V s/rad"},
      {"resistance", "ohm", "of the winding"},
      {"saturation_linear", "A/(N m)", "a in i = a tau + c tau^3 before the gear"},
      {"saturation_cubic", "A/(N m)^3", "c in the same"},
      {"voltage", "V", "of the bus, as the robot has it"},
      {"current_limit", "A", "of the driver; may be absent: none"},
      {"torque_limit", "N m", "before the gear; may be absent: none (N for a sliding joint)"},
      {"gear", "-", "turns of the motor for one of the joint"},
      {"efficiency", "-", "of the gear: motor torque = joint torque / (gear * efficiency)"},
      {"rotor_inertia", "kg m^2", "before the gear; 0 where the link's inertia holds it"},
  };
  return keys;
}

const std::vector<Key>& drag_keys() {
  static const std::vector<Key> keys = {
      {"kind", "",
       "none, distributed (a strip), point (one force) or rotation (a strip that ignores the body's motion)"},
      {"density", "kg/m^3", "of air"},
      {"coefficient", "-", "C_D"},
      {"width", "m", "of the strip (distributed, rotation)"},
      {"start", "m", "of the strip from the pivot: the shaft before it has no drag"},
      {"end", "m", "of the strip from the pivot"},
      {"point_distance", "m", "of the point force from the pivot (point)"},
      {"point_area", "m^2", "of the point force (point)"},
      {"wind", "m/s", "velocity of the air, [x, z]; may be absent: still air"},
  };
  return keys;
}

std::vector<Field> motor_fields(PlanarMotor& m, bool prismatic) {
  namespace d = dimension;
  const std::string p = "motors." + m.joint + ".";
  const Dimension effort = prismatic ? d::force : d::torque;
  if (m.ideal()) return {{p + "torque_limit", "", &m.torque_limit, effort, kPositive}};
  return {{p + "torque_constant", "", &m.torque_constant, d::torque_constant, kPositive},
          {p + "resistance", "", &m.resistance, d::resistance, kPositive},
          {p + "saturation_linear", "", &m.saturation_linear, d::saturation_linear, kPositive},
          {p + "saturation_cubic", "", &m.saturation_cubic, d::saturation_cubic, kNotNegative},
          {p + "voltage", "", &m.voltage, d::voltage, kPositive},
          {p + "current_limit", "", &m.current_limit, d::current, kPositive},
          {p + "torque_limit", "", &m.torque_limit, effort, kPositive},
          {p + "gear", "", &m.gear, d::none, kPositive},
          {p + "efficiency", "", &m.efficiency, d::none, {kTiny, 1.0}},
          {p + "rotor_inertia", "", &m.rotor_inertia, d::inertia, kNotNegative}};
}

std::vector<Field> drag_fields(PlanarDrag& t) {
  namespace d = dimension;
  const std::string p = t.name + ".drag.";
  return {{p + "kind", "", &t.kind, d::none, {}},
          {p + "density", "", &t.density, d::density, kNotNegative},
          {p + "coefficient", "", &t.coefficient, d::none, kNotNegative},
          {p + "width", "", &t.width, d::length, kNotNegative},
          {p + "start", "", &t.start, d::length, kNotNegative},
          {p + "end", "", &t.end, d::length, kNotNegative},
          {p + "point_distance", "", &t.point_distance, d::length, kNotNegative},
          {p + "point_area", "", &t.point_area, d::area, kNotNegative},
          {p + "wind", "", &t.wind_W, d::velocity, {}}};
}

std::vector<Field> model_fields(PlanarModel& model) {
  namespace d = dimension;
  std::vector<Field> fields = {{"friction", "", &model.friction, d::none, kNotNegative},
                               {"gravity", "", &model.gravity, d::acceleration, kNotNegative}};
  const auto append = [&fields](std::vector<Field> more) {
    for (Field& field : more) fields.push_back(std::move(field));
  };
  for (PlanarBody& b : model.bodies) {
    const bool base = &b == &model.bodies.front();
    const auto add = [&](const std::string& name, auto* target, const Dimension& dimension, const Bounds& allowed) {
      fields.push_back({"bodies." + b.name + "." + name, b.name + "." + name, target, dimension, allowed});
    };
    // A fixed base may be without mass, like a wall.
    add("mass", &b.mass, d::mass, base ? kNotNegative : kPositive);
    add("inertia", &b.inertia, d::inertia, base ? kNotNegative : kPositive);
    add("com", &b.com, d::length, {});
    if (!base) add("origin", &b.origin, d::length, {});
  }
  for (PlanarMotor& m : model.motors) {
    const auto body = static_cast<std::size_t>(m.body);
    append(motor_fields(m, model.bodies[body].kind == JointKind::prismatic));
  }
  for (PlanarDrag& t : model.drags) append(drag_fields(t));
  for (PlanarPoint& p : model.feet) fields.push_back({"feet." + p.name + ".point", "", &p.position, d::length, {}});
  for (PlanarPoint& p : model.points) fields.push_back({"points." + p.name + ".point", "", &p.position, d::length, {}});
  for (Coordinate& c : model.coordinates) {
    fields.push_back({"ranges." + c.name, "", &c.range, c.angular ? d::angle : d::length, {}});
  }
  for (JointRange& r : model.joint_ranges) {
    const bool slides = model.bodies[static_cast<std::size_t>(r.body)].kind == JointKind::prismatic;
    fields.push_back({"ranges." + r.joint, "", &r.range, slides ? d::length : d::angle, {}});
  }
  return fields;
}

void Field::read(const yaml::Node& node) const {
  if (auto* const* number = std::get_if<double*>(&target)) **number = node.number(dimension, allowed);
  if (auto* const* vector = std::get_if<Vec2*>(&target)) **vector = node.vec2(dimension);
  if (auto* const* bounds = std::get_if<Bounds*>(&target)) **bounds = node.bounds(dimension);
  if (auto* const* kind = std::get_if<DragKind*>(&target)) {
    const std::string name = node.choice(drag_kinds());
    for (std::size_t i = 0; i < drag_kinds().size(); ++i) {
      if (drag_kinds()[i] == name) **kind = static_cast<DragKind>(i);
    }
  }
}

std::string Field::shown() const {
  const std::string unit = " [" + unit_name(dimension) + "]";
  if (const auto* number = std::get_if<double*>(&target)) return fmt::format("{}{}", **number, unit);
  if (const auto* vector = std::get_if<Vec2*>(&target))
    return fmt::format("[{}, {}]{}", (*vector)->x(), (*vector)->y(), unit);
  if (const auto* bounds = std::get_if<Bounds*>(&target)) {
    return fmt::format("[{}, {}]{}", (*bounds)->lower, (*bounds)->upper, unit);
  }
  return drag_kinds()[static_cast<std::size_t>(**std::get_if<DragKind*>(&target))];
}

}  // namespace jaculus
