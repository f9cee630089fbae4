#include "testbed/sizes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "testbed/drives.h"
#include "testbed/limbs.h"

namespace jaculus::testbed {
namespace {

/// Torque of a motor whose files state no limit: what it gives at stall [N m].
double limit_of(const model::PlanarMotor& motor) {
  if (std::isfinite(motor.torque_limit)) return motor.torque_limit;
  if (motor.ideal()) return 1.0;  // nothing at all is known of it
  return torque_of_current(motor, motor.voltage / motor.resistance);
}

void add(const RobotFiles& files, Limb limb, MotorSizes& sizes) {
  for (const std::string& joint : files.motors_of(limb)) {
    const model::PlanarMotor& motor = *files.motor_of(joint);
    const double torque = limit_of(motor), at_joint = torque * motor.gear * motor.efficiency;
    const bool first = sizes.joints.empty();
    sizes.motor_torque = first ? torque : std::min(sizes.motor_torque, torque);
    sizes.torque = first ? at_joint : std::min(sizes.torque, at_joint);
    sizes.joints.push_back(joint);
  }
}

/// From a point on a link to where its chain leaves the base, along it in the sagittal plane.
double reach(const model::SpatialTree& tree, int link, const model::Vec3& point) {
  double length = std::hypot(point.x(), point.z());
  const int last = moving_joint(tree, link);
  for (int joint = tree.links[link].joint; joint >= 0 && last >= 0;) {
    const int parent = tree.joints[joint].parent;
    if (moving_joint(tree, parent) < 0) break;
    length += std::hypot(tree.joints[joint].origin.x(), tree.joints[joint].origin.z());
    joint = tree.links[parent].joint;
  }
  return length;
}

/// Of the longest leg; without one, of the centre of mass furthest out.
double length_of(const RobotFiles& files) {
  const model::SpatialTree& tree = files.tree;
  double longest = 0.0;
  for (const Toe& toe : files.toes)
    longest = std::max(longest, reach(tree, tree.link_index(toe.link), toe.point));
  if (longest > 0.0) return longest;

  for (int i = 0; i < count_of(tree.links); ++i)
    if (moving_joint(tree, i) >= 0) longest = std::max(longest, reach(tree, i, tree.links[i].com));
  return longest;
}

void add_electric(const RobotFiles& files, Sizes& sizes) {
  sizes.electric = !files.drives.empty();
  sizes.voltage = sizes.driver_current = sizes.largest_current = kInfinity;
  for (const Drive& drive : files.drives) {
    const model::PlanarMotor& motor = drive.motor;
    sizes.electric = sizes.electric && !motor.ideal();
    if (motor.ideal()) continue;

    const double largest = current_of_torque(motor, limit_of(motor));
    const double driver = std::isfinite(motor.current_limit) ? motor.current_limit : largest;
    sizes.voltage = std::min(sizes.voltage, motor.voltage);
    sizes.largest_current = std::min(sizes.largest_current, std::min(largest, driver));
    sizes.driver_current = std::min(sizes.driver_current, driver);
  }
}

}  // namespace

Sizes sizes_of(const RobotFiles& files) {
  Sizes sizes;
  add(files, Limb::tail, sizes.tail);
  add(files, Limb::front_leg, sizes.front);
  add(files, Limb::rear_leg, sizes.rear);
  add(files, Limb::other, sizes.other);
  for (const Limb limb : {Limb::front_leg, Limb::rear_leg}) add(files, limb, sizes.legs);

  add_electric(files, sizes);
  sizes.mass = files.tree.links[files.tree.root].mass;
  sizes.length = length_of(files);
  sizes.weight = sizes.mass * files.gravity;
  sizes.speed = std::sqrt(files.gravity * sizes.length);
  return sizes;
}

JointSize size_of(const RobotFiles& files, const Drive& drive) {
  constexpr double kSlideRadian = 0.1;  // [m]
  const double torque = limit_of(drive.motor);
  const model::SpatialJoint& joint = files.tree.joints[files.tree.joint_index(drive.joint)];
  const bool slides = joint.kind == model::SpatialJointKind::prismatic;
  return {torque * drive.motor.gear * drive.motor.efficiency, torque, slides ? kSlideRadian : 1.0};
}

double mass_of(const RobotFiles& files) {
  double mass = 0.0;
  for (const model::SpatialLink& link : files.tree.links) mass += link.mass;
  return mass;
}

double round_figure(double value) { return std::stod(fmt::format("{:.1e}", value)); }

}  // namespace jaculus::testbed
