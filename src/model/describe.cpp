#include "jaculus/model/describe.h"

#include <fmt/format.h>

namespace jaculus::model {

std::string describe_robot(const Robot& robot) {
  const PlanarModel& m = robot.planar;
  std::string text = fmt::format(
      "{}: {} planar bodies, {:.4g} kg, {} coordinates, {} motors, {} loops\n", robot.name,
      m.bodies.size(), m.total_mass(), m.size(), m.motors.size(), m.loops.size());
  for (const std::string& note : robot.notes) text += "  " + note + "\n";
  return text;
}

}  // namespace jaculus::model
