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

enum class ShapeKind { sphere, box, cylinder, capsule };

/// A shape of a link.
struct SpatialShape {
  ShapeKind kind = ShapeKind::sphere;
  /// half sizes [m]: a box's along its axes; radius, radius and half length along z of a cylinder
  /// or capsule (without its caps); a sphere's radius three times
  Vec3 size = Vec3::Zero();
  Vec3 position = Vec3::Zero();      ///< of its centre in the link's frame [m]
  Mat3 rotation = Mat3::Identity();  ///< its axes in the link's frame
  bool touches = true;               ///< others; else it only shows what the link looks like
  double friction = kNaN;            ///< sliding, of its surface [-]; NaN: the file has none
};

struct SpatialLink {
  std::string name;
  int line = 0;                 ///< of its element in the file
  double mass = 0.0;            ///< [kg]; 0 where it has no <inertial>
  Vec3 com = Vec3::Zero();      ///< centre of mass in the link's frame [m]
  Mat3 inertia = Mat3::Zero();  ///< about the centre of mass, along the link's axes [kg m^2]
  std::vector<SpatialShape> shapes;
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
  double effort = kInfinity;         ///< largest torque or force that the file states [N m or N]
  double velocity = kInfinity;       ///< fastest that the file states [rad/s or m/s]
  double damping = 0.0;              ///< that the file states [N m s/rad or N s/m]
  double friction = 0.0;             ///< the same, dry [N m or N]
  bool attached = false;             ///< by robot.yaml; the robot's file doesn't have it
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
  [[nodiscard]] double total_mass() const;                       ///< of all links [kg]
};

/// Whether what a file of somebody else's gets wrong, but other tools live with, is noted with what
/// is assumed instead, or refused.
enum class Reading { lenient, strict };

/// Reads a URDF file. Not XML, NaN, duplicate names, no single tree, a negative mass: InputError
/// with file:line. Foreign elements and attributes, masses and inertias that no body can have,
/// missing ranges: a note that begins with "assumed:", or InputError where `reading` is strict.
SpatialTree read_urdf(const std::filesystem::path& file, Reading reading = Reading::lenient);
/// The same from text; `file` stands in messages.
SpatialTree parse_urdf(const std::string& text, const std::filesystem::path& file,
                       Reading reading = Reading::lenient);

/// Sets R_BL and p_BL of every link from its joints and the root's, which stay; a link that the
/// root does not reach is InputError.
void place_links(SpatialTree& tree);

/// The part of a tree that hangs on a link, which becomes its root and stays where it is.
SpatialTree subtree(const SpatialTree& tree, int root);

}  // namespace jaculus::model
