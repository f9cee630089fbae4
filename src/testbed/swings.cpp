#include "testbed/swings.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

namespace jaculus::testbed {
namespace {

struct LinkPlace {
  model::Mat3 R = model::Mat3::Identity();
  model::Vec3 p = model::Vec3::Zero();
};

/// A link in the root's frame with every motor at rest, other joints at zero.
LinkPlace place_at_rest(const RobotFiles& files, int link) {
  const int at = files.tree.links[link].joint;
  if (at < 0) return {};
  const model::SpatialJoint& joint = files.tree.joints[at];
  double angle = 0.0;
  for (const Drive& drive : files.drives)
    if (drive.joint == joint.name) angle = files.rest_of(drive.planar);

  const LinkPlace parent = place_at_rest(files, joint.parent);
  return {parent.R * joint.rotation * Eigen::AngleAxisd(angle, joint.axis),
          parent.p + parent.R * joint.origin};
}

bool hangs_on(const model::SpatialTree& tree, int link, int ancestor) {
  while (link != ancestor && tree.links[link].joint >= 0)
    link = tree.joints[tree.links[link].joint].parent;
  return link == ancestor;
}

}  // namespace

Load load_of(const RobotFiles& files, const std::string& planar) {
  const model::SpatialTree& tree = files.tree;
  const model::SpatialJoint& joint = files.joint_of(planar);
  const LinkPlace pivot = place_at_rest(files, joint.child);
  const model::Vec3 axis = pivot.R * joint.axis;
  Load load;
  model::Vec3 moment = model::Vec3::Zero();

  for (int i = 0; i < count_of(tree.links); ++i) {
    if (!hangs_on(tree, i, joint.child)) continue;
    const model::SpatialLink& link = tree.links[i];
    const LinkPlace place = place_at_rest(files, i);
    const model::Vec3 from_pivot = place.R * link.com + place.p - pivot.p;
    const model::Vec3 own_axis = place.R.transpose() * axis;
    moment += link.mass * from_pivot;
    load.inertia += link.mass * from_pivot.cross(axis).squaredNorm();
    load.inertia += own_axis.dot(link.inertia * own_axis);
  }

  load.hold = files.gravity * axis.dot(moment.cross(model::Vec3::UnitZ()));
  load.weight = files.gravity * moment.cross(axis).norm();
  const model::PlanarMotor& motor = *files.motor_of(planar);
  load.inertia += motor.rotor_inertia * motor.gear * motor.gear;
  return load;
}

Swing swing_of(const Vector& time, int joint) {
  constexpr std::array<double, 3> kTurns = {1.2, 2.6, 4.4};
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double duration = time[time.size() - 1];
  Swing swing{Vector::Zero(time.size()), Vector::Zero(time.size())};

  for (Eigen::Index k = 0; k < time.size(); ++k) {
    const double s = time[k] / duration;
    const double half = std::sin(0.5 * kTurn * s);
    const double window = half * half, window_rate = 0.5 * kTurn * std::sin(kTurn * s);
    double sum = 0.0, sum_rate = 0.0;
    for (int i = 0; i < count_of(kTurns); ++i) {
      const double turns = kTurn * kTurns[i] * (1.0 + joint / 7.0);
      const double phase = turns * s + 2.1 * i + 1.3 * joint;
      sum += std::sin(phase) / count_of(kTurns);
      sum_rate += turns * std::cos(phase) / count_of(kTurns);
    }
    swing.value[k] = window * sum;
    swing.rate[k] = (window_rate * sum + window * sum_rate) / duration;
  }

  return swing;
}

}  // namespace jaculus::testbed
