#pragma once
// The Robot value: URDF (bodies and joints in space) plus robot.yaml (what URDF can't say), reduced
// to the sagittal plane.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/model/planar.h"
#include "jaculus/model/tolerances.h"
#include "jaculus/model/urdf.h"

namespace jaculus::model {

/// A robot as read from models/<name>/{robot.urdf,robot.yaml}.
struct Robot {
  std::string name;
  std::filesystem::path folder;
  std::filesystem::path urdf;  ///< file of its bodies and joints
  PlanarModel planar;
  /// where joints with a motor are while it is carried or stands: rest_pose [rad or m]
  std::map<std::string, double> rest_pose;
  Tolerances tolerances;  ///< how far the real one may be from all this
  /// what was merged, dropped or assumed on the way, one sentence each
  std::vector<std::string> notes;
};

/// One override of a model value by its path, as in `override: {tail.drag.coefficient: 2.0}`. "*"
/// in a path stands for any one part between dots (a path in full wins over it); a value "=path"
/// copies another model value. "attach.tail.kind" and its like replace what robot.yaml attaches,
/// before anything else is built from it. A map replaces a motor, of another kind maybe:
/// "motors.tail" with {kind: ideal, torque_limit: 9}; single values then count on top of it.
struct Override {
  std::string path;  ///< "tail.drag.coefficient", "motors.tail.resistance", "bodies.base.mass", ...
  yaml::Node value;  ///< read with the dimension of what it replaces
};

/// Finds a robot: a folder as given, relative to `relative_to` (the file that names it), or a name
/// under models/ (looked up in JACULUS_MODELS, the source tree and the installed share folder).
/// Throws InputError naming the known robots.
std::filesystem::path find_robot(const std::string& name, const std::filesystem::path& relative_to);

/// Whether a name is that of a robot under models/, wherever the file lies that names it.
bool is_installed(const std::string& name);

/// Reads, checks and reduces a robot. Every fault of the files is an InputError with file:line,
/// except for what URDF files of the field get wrong and other tools live with: that is a note,
/// unless `reading` is strict.
Robot read_robot(const std::filesystem::path& folder, const std::vector<Override>& overrides = {},
                 Reading reading = Reading::lenient);

/// The bodies in space from `base_link` on, with what robot.yaml and overrides (those of `attach`;
/// others are skipped) attach. They lie as the base's link does, `axes` are not applied.
SpatialTree read_tree(const std::filesystem::path& folder,
                      const std::vector<Override>& overrides = {});

/// Every path that an override may name, with its present value and unit ("tail.drag.coefficient =
/// 2 [-]").
std::vector<std::string> override_paths(const std::filesystem::path& folder);

/// Every key of robot.yaml with its meaning and unit, as `jaculus check --explain` prints it.
std::string explain_robot();

}  // namespace jaculus::model
