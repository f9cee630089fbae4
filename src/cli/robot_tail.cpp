#include "cli/robot_tail.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "jaculus/components/motor.h"
#include "jaculus/core/error.h"
#include "jaculus/transcription/robot_size.h"

namespace jaculus::cli {
namespace {

// Minitaur's legs are 0.34 m long, its tail 1 m, of which the last 0.4 m are a scoop of 0.18 m.
constexpr double kTailOfLeg = 1.0 / 0.34;
constexpr double kScoopOfTail = 0.4;
constexpr double kWidthOfTail = 0.18;
/// Its tail's largest torque, 3 N m behind a gear of 4, over weight (60 N) times leg length [-].
constexpr double kTorqueOfTail = 0.6;
/// What leap.yaml assumes of motors whose torque nobody stated, in the same measure [-].
constexpr double kTorqueAssumed = 0.25;

double three_digits(double value) { return std::stod(fmt::format("{:.3g}", value)); }

}  // namespace

std::string tail_section(const model::Robot& robot, const std::string& mass) {
  const model::PlanarModel& model = robot.planar;
  const int foot = model.foot_index("rear_foot");
  int hip = foot < 0 ? 0 : model.feet[foot].body;
  while (hip > 0 && model.bodies[hip].parent > 0) hip = model.bodies[hip].parent;
  const int motor = hip > 0 ? model.motor_index(model.bodies[hip].joint) : -1;
  if (motor < 0) {
    throw InputError(
        "--tail: the robot has no rear_foot on a leg with a motor at its hip; allowed: a "
        "quadruped, "
        "or `attach` in robot.yaml by hand");
  }

  const transcription::RobotSize size = transcription::robot_size(robot);
  const double length = three_digits(kTailOfLeg * size.leg_length);
  const double scoop = three_digits(kScoopOfTail * length);
  const double measure = size.body_weight * size.leg_length;
  const double stated = components::largest_joint_torque(model.motors[motor]).value;
  const double largest = std::isfinite(stated) ? stated : kTorqueAssumed * measure;
  const double gear = model.motors[motor].gear * kTorqueOfTail * measure / largest;
  const Vec2& at = model.bodies[hip].origin;
  return fmt::format(
      "\n# Minitaur's tail in proportion to these legs; kind: drag, inertial (no air acts) or "
      "none.\n"
      "attach:\n  tail:\n    kind: drag\n    to: \"{}\"\n    at: [{:.4g} m, {:.4g} m]\n"
      "    length: {} m\n    scoop: {} m\n    width: {:.3g} m\n    mass: {}\n"
      "    motor: \"{}\"   # one like it\n    gear: {:.3g}   # its largest torque is then 0.6 of "
      "weight times leg length, as Minitaur's\n",
      model.bodies.front().name, at.x(), at.y(), length, scoop, kWidthOfTail * length, mass,
      model.motors[motor].joint, gear);
}

}  // namespace jaculus::cli
