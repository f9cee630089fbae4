#include "jaculus/model/describe.h"

#include <fmt/format.h>

namespace jaculus::model {

std::string size_line(const Robot& robot) {
  const PlanarModel& m = robot.planar;
  return fmt::format("{}: {} planar bodies, {:.4g} kg, {} coordinates, {} motors, {} loops\n",
                     robot.name, m.bodies.size(), m.total_mass(), m.size(), m.motors.size(),
                     m.loops.size());
}

std::string describe_robot(const Robot& robot) {
  std::string text = size_line(robot);
  for (const std::string& note : robot.notes) text += "  " + note + "\n";
  return text;
}

}  // namespace jaculus::model
