#pragma once
// Which motor joints of a robot are its tail's, its legs' and neither; derived from the model alone.
//   tail:   joints that carry a body with drag, directly or further up its chain
//   front, rear:  joints on the chain of a foot or on a chain that a loop closes with it; front is the foot whose chain leaves
//           the base at the larger x (a single foot is a rear one)
//   other:  all the rest (a pendulum's joint)

#include <string>
#include <vector>

#include "jaculus/effects/effect.h"

namespace jaculus::effects {

struct JointGroups {
  std::vector<std::string> tail, front, rear, other;  ///< joint names of motors, in the model's order
  std::vector<int> tail_bodies;                       ///< bodies that those joints carry, and all beyond
  std::vector<int> front_bodies, rear_bodies, other_bodies;
};

JointGroups joint_groups(const PlanarModel& model);

/// A group of joints that shares an effect of the same kind: how its effects are called, and typical sizes at its joints.
struct Group {
  std::string prefix;       ///< "tail", "leg", "joint": opens the effect's name
  std::string link_prefix;  ///< "tail_link", "leg_link", "link": the same where it is about the links
  std::string caption;      ///< "the tail's joint"
  Component where = Component::body;
  std::vector<Component> also;
  std::vector<std::string> excited_by;
  double torque = 0.0;   ///< scale of a friction torque at the joint [N m]
  double rate = 0.0;     ///< scale of its rate [rad/s]
  double inertia = 0.0;  ///< scale of an inertia before the gear [kg m^2]
};
const Group& tail_group();
const Group& leg_group();
const Group& other_group();

/// The group's joints and the bodies beyond them in a model.
std::vector<std::string> joints_of(const Group& group, const PlanarModel& model);
std::vector<int> bodies_of(const Group& group, const PlanarModel& model);

/// True where the group has a motor joint.
std::function<bool(const PlanarModel&)> has_joints(const Group& group);
/// True where x or z or pitch of the base is free.
bool base_moves(const PlanarModel& model);

/// YAML text of a number that reads back to the same bits, and of a pair.
std::string text_of(double value);
std::string text_of(const Vec2& value);

}  // namespace jaculus::effects
