#include "testbed/clutter.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace jaculus::testbed {
namespace {

using Random = std::mt19937_64;

constexpr double kFarthest = 2.0;  ///< standard deviations that a healthy robot may be off by

/// A deviation, standard normal within two standard deviations.
double deviation(Random& random) {
  std::normal_distribution<double> normal;
  while (true) {
    const double e = normal(random);
    if (std::abs(e) <= kFarthest) return e;
  }
}

/// The largest torque that a joint meets [N m]: its motor's, or for a motor without a limit what it
/// takes to hold the robot's whole weight at a tenth of a metre (diagnosis grants as much; no robot
/// here has a motor that slides).
double largest_torque(const Drive& drive, const RobotFiles& files) {
  const model::PlanarMotor& motor = drive.motor;
  if (std::isfinite(motor.torque_limit)) return motor.torque_limit * motor.gear;

  double mass = 0.0;
  for (const model::SpatialLink& link : files.tree.links) mass += link.mass;
  return 0.1 * mass * files.gravity;
}

LinkClutter draw_link(const model::Tolerances& t, Random& random) {
  LinkClutter link;
  link.mass += t.mass * deviation(random);
  link.inertia += t.inertia * deviation(random);
  link.length += t.length * deviation(random);
  link.com = Vec2(t.com * deviation(random), 0.0);
  link.com.y() = t.com * deviation(random);
  return link;
}

MotorClutter draw_motor(const model::Tolerances& t, double torque, Random& random) {
  MotorClutter motor;
  motor.torque_constant += t.torque_constant * deviation(random);
  motor.resistance += t.resistance * deviation(random);
  motor.friction = t.joint_friction * std::abs(deviation(random)) * torque;
  motor.gain_p += t.gain * deviation(random);
  motor.gain_d += t.gain * deviation(random);
  motor.current_scale += t.current_scale * deviation(random);
  return motor;
}

/// The link of a link's pair that stands for both; itself where it has none.
std::string first_side(const RobotFiles& files, const std::string& link) {
  const auto pair = files.link_pairs.find(link);
  return pair == files.link_pairs.end() ? link : pair->second;
}

}  // namespace

Clutter draw_clutter(const RobotFiles& files, const model::Tolerances& tolerances,
                     std::uint64_t seed) {
  Random random(seed);
  Clutter clutter;

  for (const model::SpatialLink& link : files.tree.links) {
    const std::string one = first_side(files, link.name);
    if (!clutter.links.contains(one)) clutter.links[one] = draw_link(tolerances, random);
    const LinkClutter drawn = clutter.links[one];
    clutter.links[link.name] = drawn;
  }

  for (const Drive& drive : files.drives) {
    clutter.encoder_zero[drive.joint] = tolerances.encoder_zero * deviation(random);
    if (clutter.motors.contains(drive.planar)) continue;
    clutter.motors[drive.planar] = draw_motor(tolerances, largest_torque(drive, files), random);
  }

  clutter.floor_friction += tolerances.floor_friction * deviation(random);
  return clutter;
}

RobotFiles cluttered(const RobotFiles& files, const Clutter& clutter) {
  RobotFiles real = files;
  real.friction *= clutter.floor_friction;
  const auto off = [&](const std::string& link) {
    const auto found = clutter.links.find(link);
    return found == clutter.links.end() ? LinkClutter{} : found->second;
  };

  for (model::SpatialLink& link : real.tree.links) {
    const LinkClutter by = off(link.name);
    link.mass *= by.mass;
    link.inertia *= by.inertia;
    link.com += model::Vec3(by.com.x(), 0.0, by.com.y());
  }
  for (model::SpatialJoint& joint : real.tree.joints)
    joint.origin *= off(real.tree.links[joint.parent].name).length;
  for (Pin& pin : real.pins) {
    pin.point_a *= off(pin.link_a).length;
    pin.point_b *= off(pin.link_b).length;
  }
  for (Toe& toe : real.toes) toe.point *= off(toe.link).length;

  for (Drive& drive : real.drives) {
    const auto motor = clutter.motors.find(drive.planar);
    if (motor == clutter.motors.end()) continue;
    drive.constant = motor->second.torque_constant;
    drive.motor.resistance *= motor->second.resistance;
    drive.friction = motor->second.friction;
    drive.gain_p = motor->second.gain_p;
    drive.gain_d = motor->second.gain_d;
    drive.current_scale = motor->second.current_scale;
    const auto zero = clutter.encoder_zero.find(drive.joint);
    if (zero != clutter.encoder_zero.end()) drive.encoder_zero = zero->second;
  }

  return real;
}

}  // namespace jaculus::testbed
