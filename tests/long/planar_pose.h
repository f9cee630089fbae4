#pragma once
// The planar bodies of a model in the plane, for the checks that set MuJoCo's beside them.

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "jaculus/model/planar.h"

namespace jaculus::test {

/// x, z [m] and angle [rad] of every body, by those of the base and every joint [rad or m]. Loops
/// are as the joints leave them.
inline std::vector<Eigen::Vector3d> place_bodies(const model::PlanarModel& model,
                                                 const Eigen::Vector3d& base,
                                                 const std::map<std::string, double>& angles) {
  std::vector<Eigen::Vector3d> places{base};
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const model::PlanarBody& body = model.bodies[b];
    const Eigen::Vector3d& p = places[static_cast<std::size_t>(body.parent)];
    const double theta = angles.at(body.joint);
    const Vec2 at = Eigen::Rotation2Dd(-p[2]) * (body.origin + body.axis * theta);
    const bool turns = body.kind == model::JointKind::revolute;
    places.emplace_back(p[0] + at.x(), p[1] + at.y(),
                        p[2] + body.angle_offset + (turns ? body.sign * theta : 0.0));
  }
  return places;
}

}  // namespace jaculus::test
