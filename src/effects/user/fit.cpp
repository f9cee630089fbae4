#include "effects/user/fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "effects/families.h"
#include "effects/user/units.h"
#include "jaculus/components/motor.h"
#include "jaculus/core/error.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::effects {

using simulation::ActionKind;
using simulation::is_of_motor;
using simulation::ReadingKind;

bool of_body(ReadingKind kind) { return kind >= ReadingKind::point_x; }

std::optional<BodyPoint> body_point(const PlanarModel& model, const std::string& name) {
  for (const PlanarBody& body : model.bodies)
    if (body.name == name) return BodyPoint{name};
  for (const auto* points : {&model.feet, &model.points})
    for (const model::PlanarPoint& point : *points)
      if (point.name == name) return BodyPoint{model.bodies[point.body].name, point.position};
  return std::nullopt;
}

std::vector<std::string> joints_of(const EffectPlace& place, const PlanarModel& model) {
  if (place.kind == PlaceKind::joints) return place.names;
  const JointScope& scope = place.names.front() == "tail"   ? tail_scope()
                            : place.names.front() == "legs" ? leg_scope()
                                                            : other_scope();
  return scope.select(model).joints;
}

namespace {

std::vector<std::string> joint_names(const PlanarModel& model) {
  std::vector<std::string> names;
  for (const PlanarBody& body : model.bodies)
    if (!body.joint.empty()) names.push_back(body.joint);
  return names;
}

std::vector<std::string> body_names(const PlanarModel& model) {
  std::vector<std::string> names;
  for (const PlanarBody& body : model.bodies) names.push_back(body.name);
  for (const auto* points : {&model.feet, &model.points})
    for (const model::PlanarPoint& point : *points) names.push_back(point.name);
  return names;
}

InputError no_such(const EffectPlace& place, const char* what, const std::string& name,
                   const std::vector<std::string>& names) {
  return place.node.error(fmt::format("the robot has no {} '{}'{}; allowed: {}", what, name,
                                      yaml::did_you_mean(name, names), fmt::join(names, ", ")));
}

bool joint_slides(const PlanarModel& model, const std::string& joint) {
  return model.bodies[model.body_of_joint(joint)].kind == model::JointKind::prismatic;
}

void require_motor(const EffectPlace& place, const PlanarModel& model, const std::string& joint,
                   ReadingKind kind, const std::string& why) {
  const bool electric = kind == ReadingKind::motor_current || kind == ReadingKind::motor_voltage;
  const int motor = model.motor_index(joint);
  if (motor < 0)
    throw place.node.error(fmt::format("no motor turns '{}', and {} is of one", joint, why));
  if (electric && model.motors[motor].ideal())
    throw place.node.error(
        fmt::format("the motor of '{}' is an ideal one without {}; allowed: tau", joint, why));
  if (kind == ReadingKind::motor_limit &&
      !std::isfinite(components::largest_joint_torque(model.motors[motor]).value))
    throw place.node.error(fmt::format(
        "the motor of '{}' has no limit of torque or current for {}; allowed: tau", joint, why));
}

void require_joints(const EffectSpec& spec, const PlanarModel& model) {
  const EffectPlace& place = spec.place;
  const std::vector<std::string> joints = joints_of(place, model);
  if (joints.empty())
    throw place.node.error(
        fmt::format("the robot has no joint with a motor in the group '{}'", place.names.front()));
  for (const std::string& joint : joints) {
    if (model.body_of_joint(joint) < 0) throw no_such(place, "joint", joint, joint_names(model));
    if (joint_slides(model, joint) != place.slides)
      throw place.node.error(place.slides
                                 ? fmt::format("'{}' turns; allowed there: torque, in N m", joint)
                                 : fmt::format("'{}' slides; allowed there: force, in N", joint));
    for (const ReadingName& reading : readings_of(spec))
      if (reading.of.empty() && is_of_motor(reading.kind))
        require_motor(place, model, joint, reading.kind, reading.name);
    for (const SpecAction& action : spec.actions)
      if (action.kind == ActionKind::torque_scale)
        require_motor(place, model, joint, ReadingKind::motor_torque, "torque_scale");
  }
}

void require_part(const EffectPlace& place, const PlanarModel& model) {
  const std::string& part = place.names.front();
  if (part == "ground" && model.feet.empty())
    throw place.node.error("the robot has no feet, and the ground's friction is theirs");
  const bool electric = std::any_of(model.motors.begin(), model.motors.end(),
                                    [](const PlanarMotor& motor) { return !motor.ideal(); });
  if (part == "battery" && !electric)
    throw place.node.error("the robot has no motor that takes a voltage");
}

/// What a channel is of: a coordinate, a joint, the bus or the IMU.
void require_channel(const EffectPlace& place, const PlanarModel& model) {
  const std::string& channel = place.names.front();
  const std::string of = trajectory::parse_channel(channel).of;
  std::vector<std::string> names = joint_names(model);
  for (const model::Coordinate& c : model.coordinates)
    if (index_of(names, c.name) < 0) names.push_back(c.name);
  if (channel == "bus_voltage" || channel.starts_with("imu_pitch") || index_of(names, of) >= 0)
    return;
  throw no_such(place, "channel", channel, names);
}

}  // namespace

void require_robot(const EffectSpec& spec, const PlanarModel& model) {
  if (spec.place.at_joints()) {
    require_joints(spec, model);
  } else if (spec.place.kind == PlaceKind::part) {
    require_part(spec.place, model);
  } else if (spec.place.kind == PlaceKind::sensor) {
    require_channel(spec.place, model);
  } else if (!body_point(model, spec.place.names.front())) {
    const bool body = spec.place.kind == PlaceKind::body;
    throw no_such(spec.place, body ? "body" : "point", spec.place.names.front(), body_names(model));
  }

  for (const ReadingName& reading : readings_of(spec)) {
    if (reading.of.empty()) continue;
    if (of_body(reading.kind)) {
      if (!body_point(model, reading.of))
        throw no_such(spec.place, "body or point", reading.of, body_names(model));
      continue;
    }
    if (model.body_of_joint(reading.of) < 0)
      throw no_such(spec.place, "joint", reading.of, joint_names(model));
    if (is_of_motor(reading.kind))
      require_motor(spec.place, model, reading.of, reading.kind, reading.name);
  }
}

void require_units(const EffectSpec& spec, const PlanarModel& model) {
  require_robot(spec, model);
  if (spec.code) return;  // what it computes is in SI
  EffectSpec own = spec;
  if (spec.place.kind == PlaceKind::sensor) {
    const std::string of = trajectory::parse_channel(spec.place.names.front()).of;
    own.place.slides = model.body_of_joint(of) >= 0 && joint_slides(model, of);
    own.reading->dimension = own.place.channel_dimension();
  }
  for (const ReadingName& reading : readings_of(spec))
    if (!reading.of.empty() && !of_body(reading.kind) && joint_slides(model, reading.of))
      own.place.sliding.push_back(reading.of);
  Program program(own);
  check_units(program);
}

}  // namespace jaculus::effects
