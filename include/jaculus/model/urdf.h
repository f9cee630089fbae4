#pragma once
// A URDF file as a spatial tree, checked: every body physically possible, every joint in its place.
// Frames as in URDF: a link's frame is that of the joint that carries it; x forward, y left, z up
// where the whole robot is at its zero.

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::model {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

struct SpatialLink {
  std::string name;
  int line = 0;                  ///< of its element in the file
  double mass = 0.0;             ///< [kg]; 0 where it has no <inertial>
  Vec3 com = Vec3::Zero();       ///< centre of mass in the link's frame [m]
  Mat3 inertia = Mat3::Zero();   ///< about the centre of mass, along the link's axes [kg m^2]
  int joint = -1;                ///< joint that carries it, -1 at the root
  Mat3 R_BL = Mat3::Identity();  ///< link axes in the root's frame with every joint at zero
  Vec3 p_BL = Vec3::Zero();      ///< link origin in the root's frame with every joint at zero [m]
};

enum class SpatialJointKind { fixed, revolute, prismatic };

struct SpatialJoint {
  std::string name;
  int line = 0;
  SpatialJointKind kind = SpatialJointKind::fixed;  ///< "continuous" is revolute without a range
  int parent = -1;                                  ///< index of the parent link
  int child = -1;                                   ///< index of the child link
  Vec3 origin = Vec3::Zero();        ///< child frame in the parent's frame at joint zero [m]
  Mat3 rotation = Mat3::Identity();  ///< child axes in the parent's frame at joint zero
  Vec3 axis = Vec3::UnitX();         ///< unit, in the child's frame
  Bounds range;                      ///< [rad or m]; infinite where continuous
};

struct SpatialTree {
  std::string name;
  std::filesystem::path file;
  std::vector<SpatialLink> links;    ///< in file order
  std::vector<SpatialJoint> joints;  ///< in file order
  int root = 0;                      ///< index of the root link
  std::vector<std::string> notes;    ///< what the file says and this tree does not hold

  [[nodiscard]] int link_index(const std::string& name) const;   ///< -1 where there is none
  [[nodiscard]] int joint_index(const std::string& name) const;  ///< -1 where there is none
};

/// Reads a URDF file. Not XML, missing or unknown parts, NaN, duplicate names, no single tree, a
/// mass or inertia that no body can have: InputError with file:line.
SpatialTree read_urdf(const std::filesystem::path& file);
/// The same from text; `file` stands in messages.
SpatialTree parse_urdf(const std::string& text, const std::filesystem::path& file);

/// Sets R_BL and p_BL of every link from its joints; a link that the root does not reach is
/// InputError.
void place_links(SpatialTree& tree);

}  // namespace jaculus::model
