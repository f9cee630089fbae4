#pragma once
// A robot's files as the testbed reads them: the bodies in space from the URDF, and from robot.yaml what says which of them
// are pairs, pins and feet. Motors and air come from the model module's reader; its reduction to a plane is not used.

#include <filesystem>
#include <string>
#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/model/urdf.h"

namespace jaculus::testbed {

/// A pin between two links in space: one side of a leg.
struct Pin {
  std::string link_a, link_b;
  Vec3 point_a, point_b;         ///< in the links' frames [m]
  std::string joint_a, joint_b;  ///< the joints that follow from it
  double branch = 1.0;           ///< side on which the pin lies: sign of (b - a) x (pin - a) in the sagittal plane
};

/// A toe of one leg.
struct Toe {
  std::string name;  ///< of the planar foot
  std::string link;  ///< in space
  Vec3 point;        ///< [m]
};

/// A motor of one joint in space.
struct Drive {
  std::string joint;   ///< in space
  std::string planar;  ///< name of its pair, or its own
  PlanarMotor motor;   ///< as believed
};

struct RobotFiles {
  std::string name;
  SpatialTree tree;
  bool floating = false;
  double gravity = kGravity;
  double friction = 0.0;
  std::vector<Pin> pins;
  std::vector<Toe> toes;
  std::vector<Drive> drives;  ///< motors of a pair stand side by side
  std::vector<PlanarDrag> drags;
  std::vector<std::string> drag_links;     ///< link of each
  std::vector<std::string> planar_motors;  ///< in the order of robot.yaml
};

/// Reads a robot's folder; every fault is an InputError with file:line. A base that only slides is InputError: the testbed's
/// robots float or are fixed.
RobotFiles read_robot_files(const std::filesystem::path& folder);

}  // namespace jaculus::testbed
