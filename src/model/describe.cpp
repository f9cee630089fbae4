#include "jaculus/model/describe.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace jaculus::model {

namespace {

/// What the model has of it at the joint that stands for one of the file; NaN where it is held.
double modelled(const PlanarModel& model, const std::string& name, double PlanarMotor::*friction) {
  for (int b = 1; b < count_of(model.bodies); ++b) {
    for (const FileJoint& joint : model.bodies[b].file_joints) {
      if (joint.name != name) continue;
      const int m = model.motor_index(model.bodies[b].joint);
      return m < 0 ? 0.0 : model.motors[m].*friction;
    }
  }
  return kNaN;
}

std::vector<std::string> joints_left_out(const Robot& robot, const SpatialTree& file,
                                         double SpatialJoint::*stated,
                                         double PlanarMotor::*friction) {
  std::vector<std::string> joints;
  for (const SpatialJoint& joint : file.joints) {
    if (joint.*stated > 0.0 && modelled(robot.planar, joint.name, friction) == 0.0)
      joints.push_back(fmt::format("{} {:.3g}", joint.name, joint.*stated));
  }
  return joints;
}

}  // namespace

std::string size_line(const Robot& robot) {
  const PlanarModel& m = robot.planar;
  return fmt::format("{}: {} planar bodies, {:.4g} kg, {} coordinates, {} motors, {} loops\n",
                     robot.name, m.bodies.size(), m.total_mass(), m.size(), m.motors.size(),
                     m.loops.size());
}

std::string describe_robot(const Robot& robot) {
  std::string text = size_line(robot);
  for (const std::string& note : robot.notes) text += "  " + note + "\n";
  for (const std::string& note : friction_left_out(robot)) text += "  " + note + "\n";
  return text;
}

std::vector<std::string> friction_left_out(const Robot& robot) {
  const SpatialTree file = read_urdf(robot.urdf);
  std::vector<std::string> sentences;
  const auto add = [&](const char* kind, const char* unit, const char* key,
                       const std::vector<std::string>& joints) {
    if (joints.empty()) return;
    sentences.push_back(fmt::format(
        "{} states {} friction [{}] that robot.yaml has not ({}): {}; plans and simulations don't "
        "know it",
        robot.urdf.filename().string(), kind, unit, key, fmt::join(joints, ", ")));
  };

  add("dry", "N m", "dry_friction of a motor",
      joints_left_out(robot, file, &SpatialJoint::friction, &PlanarMotor::dry_friction));
  add("viscous", "N m s/rad", "viscous_friction of a motor",
      joints_left_out(robot, file, &SpatialJoint::damping, &PlanarMotor::viscous_friction));
  return sentences;
}

}  // namespace jaculus::model
