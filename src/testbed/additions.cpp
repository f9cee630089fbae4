#include "testbed/additions.h"

#include <fmt/format.h>

#include <cmath>

#include "testbed/sizes.h"

namespace jaculus::testbed {
namespace {

constexpr double kLoadRate = 15.0;  ///< of a sliding load on its spring [rad/s]
constexpr double kLoadDamping = 0.1, kMountDamping = 0.05;  ///< ratios to critical [-]

std::string slide(const std::string& name, const model::Vec3& axis, double stiffness,
                  double damping) {
  return fmt::format(
      "<joint name=\"{}\" type=\"slide\" axis=\"{:.17g} {:.17g} {:.17g}\" stiffness=\"{:.17g}\" "
      "damping=\"{:.17g}\"/>",
      name, axis.x(), axis.y(), axis.z(), stiffness, damping);
}

}  // namespace

std::string additions_to_base(const Changes& changes) {
  std::string text;
  if (changes.payload > 0.0) {
    text += fmt::format(
        "<body name=\"payload\" pos=\"{:.17g} 0 {:.17g}\"><inertial pos=\"0 0 0\" "
        "mass=\"{:.17g}\" "
        "diaginertia=\"1e-6 1e-6 1e-6\"/></body>\n",
        changes.payload_place.x(), changes.payload_place.y(), changes.payload);
  }

  if (const double m = changes.outside.loose_mass; m > 0.0) {
    text += fmt::format(
        "<body name=\"loose\">{}<inertial pos=\"0 0 0\" mass=\"{:.17g}\" diaginertia=\"1e-6 1e-6 "
        "1e-6\"/></body>\n",
        slide("loose", model::Vec3::UnitX(), 400.0 * m, 4.0 * m), m);
  }
  return text;
}

int loaded_link(const RobotFiles& files) {
  int last = -1;
  for (const Drive& drive : files.drives) {
    const int link = files.tree.joints[files.tree.joint_index(drive.joint)].child;
    if (drive.limb == Limb::other && files.tree.links[link].mass > 0.0) last = link;
  }
  return last;
}

std::string load_on_link(const RobotFiles& files, const Changes& changes) {
  const model::SpatialLink& link = files.tree.links[loaded_link(files)];
  const model::SpatialJoint& joint = files.tree.joints[link.joint];
  const bool slides = joint.kind == model::SpatialJointKind::prismatic || !(link.com.norm() > 0.0);
  const model::Vec3 axis = slides ? joint.axis : link.com.normalized();

  const double m = changes.outside.sliding_load;
  return fmt::format(
      "<body name=\"sliding_load\" pos=\"{:.17g} {:.17g} {:.17g}\">{}<inertial pos=\"0 0 0\" "
      "mass=\"{:.17g}\" diaginertia=\"1e-9 1e-9 1e-9\"/></body>\n",
      link.com.x(), link.com.y(), link.com.z(),
      slide("sliding_load", axis, kLoadRate * kLoadRate * m, 2.0 * kLoadDamping * kLoadRate * m),
      m);
}

double mount_mass(const RobotFiles& files) { return mass_of(files); }

std::string mount_below(const RobotFiles& files, const Changes& changes) {
  const double k = 1.0 / changes.outside.mount_compliance;
  const double damping = 2.0 * kMountDamping * std::sqrt(k * (mass_of(files) + mount_mass(files)));
  return fmt::format(
      "<body name=\"mount\">{}<inertial pos=\"0 0 0\" mass=\"{:.17g}\" diaginertia=\"1 1 1\"/>\n",
      slide("mount", model::Vec3::UnitX(), k, damping), mount_mass(files));
}

}  // namespace jaculus::testbed
