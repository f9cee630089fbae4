#include "diagnosis/forward/missing_forces.h"

#include <cmath>

namespace jaculus::diagnosis {

double large_force(const model::PlanarModel& robot, const model::PlanarMotor& motor, double lever) {
  const double limit = motor.torque_limit * motor.gear;
  if (std::isfinite(limit)) return limit;
  const double weight = robot.total_mass() * robot.gravity;
  const bool turns = !robot.slides(motor);
  return turns ? lever * weight : weight;
}

std::vector<std::pair<std::string, double>> force_scales(const model::PlanarModel& robot,
                                                         double lever) {
  const double weight = robot.total_mass() * robot.gravity, moment = lever * weight;
  std::vector<std::pair<std::string, double>> scales;
  for (const model::Coordinate& c : robot.coordinates) {
    if (c.name == "x" || c.name == "z") scales.emplace_back(c.name, weight);
    if (c.name == "pitch") scales.emplace_back(c.name, moment);
    if (robot.body_of_joint(c.name) < 0 || robot.motor_index(c.name) >= 0) continue;
    scales.emplace_back(c.name, c.angular ? moment : weight);
  }
  for (const model::PlanarMotor& motor : robot.motors)
    scales.emplace_back(motor.joint, large_force(robot, motor, lever));
  return scales;
}

bool has_place(const model::PlanarModel& robot, const std::string& name) {
  return robot.coordinate_index(name) >= 0 || robot.body_of_joint(name) >= 0;
}

std::string force_unit(const model::PlanarModel& robot, const std::string& name) {
  const int body = robot.body_of_joint(name);
  const bool slides = body >= 0 && robot.bodies[body].kind == model::JointKind::prismatic;
  return slides || name == "x" || name == "z" ? "N" : "N m";
}

simulation::Push box_push(const std::string& name, double value, double start, double duration) {
  simulation::Push push{start, duration};
  if (name == "x")
    push.force_W.x() = value;
  else if (name == "z")
    push.force_W.y() = value;
  else if (name == "pitch")
    push.moment = value;
  else {
    push.joint = name;
    push.torque = value;
  }
  return push;
}

}  // namespace jaculus::diagnosis
