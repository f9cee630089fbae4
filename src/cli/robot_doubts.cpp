#include "cli/robot_doubts.h"

#include <fmt/format.h>

#include <cmath>

#include "jaculus/components/motor.h"
#include "jaculus/transcription/robot_size.h"

namespace jaculus::cli {

std::vector<std::string> doubtful_limits(const model::Robot& robot) {
  constexpr double kMost = 10.0;  // of weight times leg length; robots that leap have about one
  // rad a leg_time: the leap template ends at 0.7 leg lengths a leg_time
  constexpr double kSlowest = 0.7;
  std::vector<std::string> doubtful;
  if (robot.planar.feet.empty() || robot.planar.gravity == 0.0) return doubtful;
  const transcription::RobotSize size = transcription::robot_size(robot);
  for (const model::PlanarMotor& motor : robot.planar.motors) {
    const double torque = components::largest_joint_torque(motor).value;
    const double measures = torque / (size.body_weight * size.leg_length);
    if (std::isfinite(torque) && measures > kMost)
      doubtful.push_back(fmt::format(
          "motors.{}: the file's {:.4g} N m is {:.0f} times weight times leg length, a place "
          "holder?",
          motor.joint, torque, measures));
    const double speed = motor.speed_limit / motor.gear;
    if (speed * size.leg_time < kSlowest)
      doubtful.push_back(fmt::format(
          "motors.{}: at the file's {:.3g} rad/s a leg's end moves at {:.2g} m/s, too slow for a "
          "leap; a place holder?",
          motor.joint, speed, speed * size.leg_length));
  }
  return doubtful;
}

}  // namespace jaculus::cli
