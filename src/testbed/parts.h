#pragma once
// Rigid parts of the robot, put together and taken apart.

#include "jaculus/testbed/changes.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

inline constexpr double kPlateMass = 0.01;  ///< of a floor plate [kg]

/// Mass, centre of mass and pitch inertia of one rigid part; inertias about the other axes play no
/// part in the plane.
struct Part {
  double mass = 0.0;
  model::Vec3 com = model::Vec3::Zero();
  model::Mat3 inertia = model::Mat3::Zero();
};

/// A link with all that is fixed to it, seen as one body. Only its pitch inertia is meant.
Part composite(const model::SpatialTree& tree, int index);

/// What the link itself must be so that, with all that is fixed to it, it is `whole`.
Part own_share(const model::SpatialTree& tree, int index, Part whole);

/// Of each hinge of the shaft [N m/rad].
double hinge_stiffness(const RobotFiles& files, const Changes& changes,
                       const std::vector<double>& hinges);

}  // namespace jaculus::testbed
