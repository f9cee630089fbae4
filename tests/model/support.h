#pragma once
// Helpers of the model's tests: robots written to a temporary folder, proposed and read back, the
// real plans, a forward kinematics of its own.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "jaculus/core/installation.h"
#include "jaculus/model/planar.h"
#include "jaculus/model/propose.h"
#include "jaculus/model/robot.h"

namespace jaculus::testing {

inline const std::filesystem::path kModels = source_folder() / "models";

/// A folder that is gone with the object.
class Folder {
 public:
  Folder()
      : path_(std::filesystem::path(::testing::TempDir()) /
              ("jaculus_model_" + std::to_string(std::random_device{}()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The text with the first `from` replaced; a test that replaces nothing is wrong.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "test edits what is not there: " << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// The folder of real data: JACULUS_DATA, or ../shared/data beside the source tree. Empty where
/// absent.
inline std::filesystem::path data_folder() {
  if (const char* given = std::getenv("JACULUS_DATA")) return given;
  const std::filesystem::path beside = source_folder().parent_path() / "shared" / "data";
  return std::filesystem::is_directory(beside) ? beside : std::filesystem::path();
}

/// Pose of a body: origin in the world [m] and absolute angle [rad].
struct Pose {
  Vec2 p = Vec2::Zero();
  double phi = 0.0;
  [[nodiscard]] Vec2 at(const Vec2& v) const {
    return p + Vec2(std::cos(phi) * v.x() + std::sin(phi) * v.y(),
                    -std::sin(phi) * v.x() + std::cos(phi) * v.y());
  }
};

/// Poses of all bodies from the base's pose and every joint's value, by the formulas at the top of
/// planar.h.
inline std::vector<Pose> poses(const model::PlanarModel& model, const Pose& base,
                               const std::map<std::string, double>& joints) {
  std::vector<Pose> result = {base};
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const model::PlanarBody& body = model.bodies[b];
    const double theta = joints.at(body.joint);
    const Pose& parent = result[body.parent];
    Pose pose;
    pose.p = parent.at(body.origin + body.axis * theta);
    pose.phi = parent.phi + body.angle_offset +
               (body.kind == model::JointKind::revolute ? body.sign * theta : 0.0);
    result.push_back(pose);
  }
  return result;
}

/// What is proposed of a URDF text, and the robot that is read back from it.
struct Imported {
  model::Proposal proposal;
  model::Robot robot;
};

inline Imported imported(const std::string& urdf, const model::ProposeOptions& options = {}) {
  const Folder folder;
  const model::Proposal proposal =
      model::propose_robot(model::parse_urdf(urdf, "robot.urdf"), options);
  folder.write("robot.urdf", urdf);
  folder.write("robot.yaml", proposal.yaml);
  return {proposal, model::read_robot(folder.path())};
}

inline std::vector<std::string> names(const std::vector<model::Coordinate>& coordinates) {
  std::vector<std::string> all;
  for (const model::Coordinate& c : coordinates) all.push_back(c.name);
  return all;
}

/// Parts of a robot's URDF text. `com`, `origin`, `axis`: three numbers; `shape`: an element, for
/// collisions.
inline std::string link(const std::string& name, double mass, const std::string& com,
                        const std::string& shape = "") {
  return fmt::format(
      "<link name=\"{}\"><inertial><origin xyz=\"{}\"/><mass value=\"{}\"/><inertia ixx=\"0.01\" "
      "iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{}</link>\n",
      name, com, mass,
      shape.empty() ? "" : "<collision><geometry>" + shape + "</geometry></collision>");
}

inline std::string joint(const std::string& name, const std::string& type,
                         const std::string& parent, const std::string& child,
                         const std::string& origin, const std::string& axis,
                         const std::string& effort = "10") {
  return fmt::format(
      "<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/><origin "
      "xyz=\"{}\"/><axis "
      "xyz=\"{}\"/><limit lower=\"-2\" upper=\"2\" effort=\"{}\" velocity=\"9\"/></joint>\n",
      name, type, parent, child, origin, axis, effort);
}

}  // namespace jaculus::testing
