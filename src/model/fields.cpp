#include "model/fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/model/values.h"

namespace jaculus::model {
namespace {

// Where zero is impossible but any positive number is fine, this stands for "more than 0".
constexpr double kTiny = 1e-12;
constexpr Bounds kPositive{kTiny, kInfinity};
constexpr Bounds kNotNegative{0.0, kInfinity};
const std::string kNone = ".inf";  ///< of a limit, as YAML has infinity

}  // namespace

const std::vector<std::string>& drag_kinds() {
  // in DragKind's order
  static const std::vector<std::string> names = {"none", "distributed", "point", "rotation"};
  return names;
}

const std::vector<Key<PlanarMotor>>& motor_keys() {
  namespace d = dimension;
  using M = PlanarMotor;
  static const std::vector<Key<M>> keys = {
      {"torque_constant", &M::torque_constant, d::torque_constant, kPositive,
       "k_t before the gear, equally V s/rad", true},
      {"resistance", &M::resistance, d::resistance, kPositive, "of the winding", true},
      {"saturation_linear", &M::saturation_linear, d::saturation_linear, kPositive,
       "a in i = a tau + c tau^3 before the gear", true},
      {"saturation_cubic", &M::saturation_cubic, d::saturation_cubic, kNotNegative, "c in the same",
       true},
      {"voltage", &M::voltage, d::voltage, kPositive, "of the bus, as the robot has it", true},
      {"current_limit", &M::current_limit, d::current, kPositive,
       "of the driver; may be absent: none"},
      {"torque_limit", &M::torque_limit, d::torque, kPositive,
       "before the gear; may be absent: none (N for a sliding joint)"},
      {"gear", &M::gear, d::none, kPositive, "turns of the motor for one of the joint", true},
      {"efficiency",
       &M::efficiency,
       d::none,
       {kTiny, 1.0},
       "of the gear: motor torque = joint torque / (gear * efficiency)",
       true},
      {"rotor_inertia", &M::rotor_inertia, d::inertia, kNotNegative,
       "before the gear; 0 where the link's inertia holds it", true},
      {"speed_limit", &M::speed_limit, d::angular_velocity, kPositive,
       "before the gear, which plans with motor_limits keep below; may be absent: none (m/s for a "
       "sliding joint)"},
      {"viscous_friction", &M::viscous_friction, d::angular_damping, kNotNegative,
       "of motor, gear and bearing at the joint, in proportion to its speed; may be absent: 0 (N "
       "s/m for a sliding joint)"},
      {"dry_friction", &M::dry_friction, d::torque, kNotNegative,
       "the same, whatever the speed; may be absent: 0 (N for a sliding joint)"},
  };

  return keys;
}

const std::vector<std::string_view>& ideal_motor_keys() {
  static const std::vector<std::string_view> keys = {"torque_limit", "speed_limit",
                                                     "viscous_friction", "dry_friction"};
  return keys;
}

const std::vector<Key<PlanarDrag>>& drag_keys() {
  namespace d = dimension;
  using D = PlanarDrag;
  static const std::vector<Key<D>> keys = {
      {"kind",
       &D::kind,
       d::none,
       {},
       "none, distributed (a strip), point (one force) or rotation (a strip that ignores the "
       "body's motion)",
       true},
      {"density", &D::density, d::density, kNotNegative, "of air", true},
      {"coefficient", &D::coefficient, d::none, kNotNegative, "C_D", true},
      {"width", &D::width, d::length, kNotNegative, "of the strip (distributed, rotation)"},
      {"start", &D::start, d::length, kNotNegative,
       "of the strip from the pivot: the shaft before it has no drag"},
      {"end", &D::end, d::length, kNotNegative, "of the strip from the pivot"},
      {"point_distance", &D::point_distance, d::length, kNotNegative,
       "of the point force from the pivot (point)"},
      {"point_area", &D::point_area, d::area, kNotNegative, "of the point force (point)"},
      {"wind",
       &D::wind_W,
       d::velocity,
       {},
       "velocity of the air, [x, z]; may be absent: still air"},
  };

  return keys;
}

namespace {

template <class S>
Field field_of(S& section, const std::string& prefix, const Key<S>& key) {
  Field field{prefix + std::string(key.name), "", {}, key.dimension, key.allowed, key.required};
  field.limit = key.name.ends_with("_limit");
  std::visit([&](auto member) { field.target = &(section.*member); }, key.member);
  return field;
}

/// The dimension of a motor's figure where its joint slides.
Dimension sliding(const Dimension& turning) {
  constexpr Dimension kForceRate{0, 1, -1, 0, 0};  // N s/m
  if (turning == dimension::torque) return dimension::force;
  if (turning == dimension::angular_velocity) return dimension::velocity;
  return turning == dimension::angular_damping ? kForceRate : turning;
}

}  // namespace

std::vector<Field> motor_fields(PlanarMotor& motor, bool prismatic) {
  const std::vector<std::string_view>& of_ideal = ideal_motor_keys();
  std::vector<Field> fields;
  for (const Key<PlanarMotor>& key : motor_keys()) {
    const bool ideal = std::find(of_ideal.begin(), of_ideal.end(), key.name) != of_ideal.end();
    const bool rotor = key.name == "rotor_inertia" && motor.rotor_inertia > 0.0;
    if (motor.ideal() && !ideal && !rotor) continue;
    fields.push_back(field_of(motor, "motors." + motor.joint + ".", key));
    if (prismatic) fields.back().dimension = sliding(key.dimension);
  }
  return fields;
}

std::vector<Field> drag_fields(PlanarDrag& drag) {
  std::vector<Field> fields;
  for (const Key<PlanarDrag>& key : drag_keys())
    fields.push_back(field_of(drag, drag.name + ".drag.", key));
  return fields;
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
    const auto add = [&](const std::string& name, auto* target, const Dimension& dimension,
                         const Bounds& allowed) {
      fields.push_back(
          {"bodies." + b.name + "." + name, b.name + "." + name, target, dimension, allowed});
    };
    // A fixed base may be without mass, like a wall.
    add("mass", &b.mass, d::mass, base ? kNotNegative : kPositive);
    add("inertia", &b.inertia, d::inertia, base ? kNotNegative : kPositive);
    add("com", &b.com, d::length, {});
    if (!base) add("origin", &b.origin, d::length, {});
  }

  for (PlanarMotor& m : model.motors) {
    const std::size_t body = m.body;
    append(motor_fields(m, model.bodies[body].kind == JointKind::prismatic));
  }
  for (PlanarDrag& t : model.drags) append(drag_fields(t));

  for (PlanarPoint& p : model.feet)
    fields.push_back({"feet." + p.name + ".point", "", &p.position, d::length, {}});
  for (PlanarPoint& p : model.points)
    fields.push_back({"points." + p.name + ".point", "", &p.position, d::length, {}});

  for (Coordinate& c : model.coordinates) {
    fields.push_back({"ranges." + c.name, "", &c.range, c.angular ? d::angle : d::length, {}});
  }
  for (JointRange& r : model.joint_ranges) {
    const bool slides = model.bodies[r.body].kind == JointKind::prismatic;
    fields.push_back({"ranges." + r.joint, "", &r.range, slides ? d::length : d::angle, {}});
  }

  return fields;
}

std::vector<ModelValue> model_values(const PlanarModel& model) {
  PlanarModel copy = model;  // fields may be written to
  std::vector<ModelValue> values;
  for (const Field& field : model_fields(copy)) {
    const auto* number = std::get_if<double*>(&field.target);
    if (number != nullptr && std::isfinite(**number))
      values.push_back({field.path, field.alias, **number});
  }
  return values;
}

void Field::read(const yaml::Node& node) const {
  if (auto* const* number = std::get_if<double*>(&target)) {
    const bool none = limit && node.is_scalar() && node.dump() == kNone;
    **number = none ? kInfinity : node.number(dimension, allowed);
  }
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
  if (const auto* number = std::get_if<double*>(&target))
    return (std::isinf(**number) ? kNone : fmt::format("{}", **number)) + unit;
  if (const auto* vector = std::get_if<Vec2*>(&target))
    return fmt::format("[{}, {}]{}", (*vector)->x(), (*vector)->y(), unit);
  if (const auto* bounds = std::get_if<Bounds*>(&target)) {
    return fmt::format("[{}, {}]{}", (*bounds)->lower, (*bounds)->upper, unit);
  }
  return drag_kinds()[static_cast<std::size_t>(**std::get_if<DragKind*>(&target))];
}

}  // namespace jaculus::model
