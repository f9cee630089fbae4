#include "cli/robot_tail.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string>

#include "cli/robot_leap.h"
#include "jaculus/components/motor.h"
#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "jaculus/transcription/robot_size.h"

namespace jaculus::cli {
namespace {

// Minitaur's legs are 0.34 m long, its tail 1 m, of which the last 0.4 m are a scoop of 0.18 m.
constexpr double kTailOfLeg = 1.0 / 0.34;
constexpr double kScoopOfTail = 0.4;
constexpr double kWidthOfTail = 0.18;
/// Its tail's largest torque, 3 N m behind a gear of 4, over weight (60 N) times leg length [-].
constexpr double kTorqueOfTail = 0.6;

double three_digits(double value) { return std::stod(fmt::format("{:.3g}", value)); }

}  // namespace

std::string tail_section(const model::Robot& robot, const std::string& mass) {
  const model::PlanarModel& model = robot.planar;
  const int foot = model.foot_index("rear_foot");
  const int hip = foot < 0 ? 0 : transcription::first_of_leg(model, model.feet[foot]);
  const int motor = hip > 0 ? model.motor_index(model.bodies[hip].joint) : -1;
  if (motor < 0) {
    throw InputError(
        "--tail: the robot has no rear_foot on a leg with a motor at its hip; allowed: a "
        "quadruped (--hold passive where joints without motors lead to its legs), or `attach` in "
        "robot.yaml by hand");
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
      "attach:\n  tail:\n    kind: drag\n    to: {}\n    at: [{:.4g} m, {:.4g} m]\n"
      "    length: {} m\n    scoop: {} m\n    width: {:.3g} m\n    mass: {}\n"
      "    motor: {}   # one like it\n    gear: {:.3g}   # with the {:.4g} N m that this joint "
      "has now, 0.6 of weight times leg length, as Minitaur's;\n"
      "                # put in another where you change that motor\n",
      yaml::quoted(model.bodies.front().name), at.x(), at.y(), length, scoop, kWidthOfTail * length,
      mass, yaml::quoted(model.motors[motor].joint), gear, largest);
}

void check_tail_mass(const std::string& mass) {
  if (mass.empty()) return;
  const bool share = mass.find('%') != std::string::npos;
  const Bounds some{1e-9, share ? 1.0 : kInfinity};
  try {
    const yaml::Node node = yaml::Node::parse("{mass: " + yaml::quoted(mass) + "}", "--tail");
    (void)node.at("mass").number(share ? dimension::none : dimension::mass, some);
  } catch (const InputError& error) {
    // a plain number is in kg
    double value = 0.0;
    const auto [end, code] = std::from_chars(mass.data(), mass.data() + mass.size(), value);
    if (code == std::errc() && end == mass.data() + mass.size() && value > 0.0) return;
    throw InputError(fmt::format(
        "--tail: '{}' given; allowed: a mass, as 1.2 kg or 10 %, of at most 100 %", mass));
  }
}

void state_limits(const model::PlanarModel& model, model::SpatialTree& tree) {
  for (const model::PlanarMotor& motor : model.motors) {
    for (const model::FileJoint& side : model.bodies[motor.body].file_joints) {
      model::SpatialJoint& joint = tree.joints[tree.joint_index(side.name)];
      if (!std::isfinite(joint.effort))
        joint.effort = components::largest_joint_torque(motor).value;
      if (!std::isfinite(joint.velocity)) joint.velocity = motor.speed_limit / motor.gear;
    }
  }
}

}  // namespace jaculus::cli
