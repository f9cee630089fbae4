#pragma once
// A robot's files as the testbed reads them: the bodies in space from the URDF, and from robot.yaml
// what says which of them are pairs, pins and feet. Motors and air come from the model module's
// reader; its reduction to a plane is not used.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/model/tolerances.h"
#include "jaculus/model/urdf.h"
#include "testbed/limbs.h"

namespace jaculus::testbed {

/// A motor of one joint in space.
struct Drive {
  std::string joint;                  ///< in space
  std::string planar;                 ///< name of its pair, or its own
  model::PlanarMotor motor;           ///< as believed
  Limb limb = Limb::other;            ///< that the joint moves
  double constant = 1.0;              ///< of the torque constant, true over believed [-]
  double friction = 0.0;              ///< dry, of a healthy bearing and gear, at the joint [N m]
  double encoder_zero = 0.0;          ///< what its encoder reads too much [rad]
  double gain_p = 1.0, gain_d = 1.0;  ///< of the loop's gains, true over stated [-]
  double current_scale = 1.0;         ///< of logged current and torque, logged over true [-]
};

struct RobotFiles {
  std::string name;
  model::SpatialTree tree;
  bool floating = false;
  double gravity = kGravity;
  double friction = 0.0;
  std::vector<Pin> pins;
  std::vector<Toe> toes;
  std::vector<Drive> drives;  ///< motors of a pair stand side by side
  std::vector<model::PlanarDrag> drags;
  std::vector<std::string> drag_links;     ///< link of each
  std::vector<std::string> planar_motors;  ///< in the order of robot.yaml
  /// of every link in space that has a pair: the one that stands for both
  std::map<std::string, std::string> link_pairs;
  model::Tolerances tolerances;        ///< of the builder
  std::map<std::string, double> rest;  ///< rest_pose of robot.yaml, by planar joint [rad or m]

  /// Planar joints with a motor that move a limb, in the order of robot.yaml.
  [[nodiscard]] std::vector<std::string> motors_of(Limb limb) const;
  /// Drives of one planar joint, the left one first: indices into `drives`.
  [[nodiscard]] std::vector<int> sides_of(const std::string& planar) const;
  /// The first motor of a planar joint; null where it has none.
  [[nodiscard]] const model::PlanarMotor* motor_of(const std::string& planar) const;
  /// The joint in space that a planar one stands for (the left one of a pair).
  [[nodiscard]] const model::SpatialJoint& joint_of(const std::string& planar) const;
  [[nodiscard]] double rest_of(const std::string& planar) const;  ///< [rad or m]
};

/// Reads a robot's folder; every fault is an InputError with file:line. A base that only slides is
/// InputError: the testbed's robots float or are fixed.
RobotFiles read_robot_files(const std::filesystem::path& folder);

}  // namespace jaculus::testbed
