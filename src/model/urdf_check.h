#pragma once
// What is checked of a URDF's text before urdfdom reads it. urdfdom knows no line numbers and takes
// many faults silently (unknown elements, NaN, a second <inertial>), so they are found here, each
// with its line: refused, or noted with what is assumed instead.

#include <filesystem>
#include <string>
#include <vector>

#include "jaculus/core/error.h"
#include "jaculus/model/urdf.h"
#include "model/assumptions.h"

namespace jaculus::model {

/// The skeleton of the tree with the lines of its elements, and what the file holds beyond bodies
/// and joints.
struct UrdfOutline {
  struct Link {
    std::string name;
    int line = 0;
    std::vector<SpatialShape> shapes;  ///< for contact
  };
  struct Joint {
    std::string name;
    int line = 0;
    std::string parent;      ///< a link of this file
    std::string child;       ///< a link of this file
    bool unlimited = false;  ///< has no range though its type asks for one
  };
  std::vector<Link> links;    ///< in file order
  std::vector<Joint> joints;  ///< in file order
  std::vector<std::string> notes;
  std::string text;  ///< the file as urdfdom can read it, assumptions written in
};

/// Checks the text of a URDF file; throws InputError with file:line.
UrdfOutline check_urdf_text(const std::string& text, const std::filesystem::path& file,
                            Assumptions& assumptions);

/// "file:line: what".
InputError urdf_error(const std::filesystem::path& file, int line, const std::string& what);

}  // namespace jaculus::model
