#pragma once
// Robots in MuJoCo's own format, read by MuJoCo itself, and a tree in space as URDF.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "jaculus/model/urdf.h"

namespace jaculus::model {

/// Friction of what touches on a link.
struct Surface {
  std::string link;
  double friction = kNaN;  ///< sliding [-]; NaN: the file has none
  std::string source;      ///< what told it, or why it is unknown; may be empty
};

struct MjcfRobot {
  SpatialTree tree;
  bool floating = false;               ///< its base has a free joint
  std::map<std::string, double> pose;  ///< of the first keyframe, by joint [rad or m]; may be empty
  /// what a joint adds to its own inertia, by joint that turns [kg m^2]; where above 0
  std::map<std::string, double> armature;
  std::vector<Surface> surfaces;   ///< what told the friction of the tree's shapes
  std::vector<std::string> notes;  ///< what the file says and the tree doesn't hold
};

/// Whether a file's first element is <mujoco>.
bool is_mjcf(const std::filesystem::path& file);

/// Reads an MJCF file by MuJoCo's own reader: masses and inertias as MuJoCo has them (of geoms
/// where bodies state none), joints with ranges, largest torques of actuators, shapes that touch. A
/// body with several joints is a chain of links without mass. Of a newer file what this MuJoCo
/// doesn't know is left out, a note each that begins with "assumed:"; InputError where `reading` is
/// strict. InputError where MuJoCo refuses the file for anything else, nothing moves, or this build
/// has no MuJoCo.
MjcfRobot read_mjcf(const std::filesystem::path& file, Reading reading = Reading::lenient);

/// A tree as the text of a URDF file that reads back as the same tree, to 1e-15 relative; friction
/// of shapes has no place there.
std::string write_urdf(const SpatialTree& tree);

/// Gives shapes of a tree that was read back the friction that they had when it was written.
void keep_friction(const SpatialTree& written, SpatialTree& tree);

}  // namespace jaculus::model
