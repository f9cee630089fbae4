#include "effects/scope.h"

#include <algorithm>

namespace jaculus::effects {
namespace {

using model::PlanarModel;
using trajectory::ExperimentKind;

template <class Value>
bool contains(const std::vector<Value>& list, const Value& value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

void add_all(std::vector<int>& to, const std::vector<int>& from) {
  for (const int body : from)
    if (!contains(to, body)) to.push_back(body);
}

/// Bodies from `body` towards the base, the base aside.
std::vector<int> chain(const PlanarModel& model, int body) {
  std::vector<int> bodies;
  for (; body > 0; body = model.bodies[body].parent) bodies.push_back(body);
  return bodies;
}

/// The chain of a foot and those that loops close with it.
std::vector<int> leg_bodies(const PlanarModel& model, const model::PlanarPoint& foot) {
  std::vector<int> leg = chain(model, foot.body);
  for (std::size_t size = 0; size != leg.size();) {
    size = leg.size();
    for (const model::PlanarLoop& loop : model.loops) {
      if (contains(leg, loop.body_a)) add_all(leg, chain(model, loop.body_b));
      if (contains(leg, loop.body_b)) add_all(leg, chain(model, loop.body_a));
    }
  }
  return leg;
}

/// Where a foot's chain leaves the base [m].
double root_x(const PlanarModel& model, const model::PlanarPoint& foot) {
  const std::vector<int> bodies = chain(model, foot.body);
  return bodies.empty() ? foot.position.x() : model.bodies[bodies.back()].origin.x();
}

/// Adds to some bodies all that they carry.
void add_carried(const PlanarModel& model, std::vector<int>& bodies) {
  for (int b = 1; b < static_cast<int>(model.bodies.size()); ++b)
    if (contains(bodies, model.bodies[b].parent)) add_all(bodies, {b});
}

/// Bodies of the tails: those with drag, what lies between them and the base, what they carry.
std::vector<int> tail_bodies(const PlanarModel& model) {
  std::vector<int> tail;
  for (const model::PlanarDrag& drag : model.drags) add_all(tail, chain(model, drag.body));

  add_carried(model, tail);
  return tail;
}

void set_joints(const PlanarModel& model, JointSet& set) {
  for (const model::PlanarMotor& motor : model.motors)
    if (contains(set.bodies, motor.body)) set.joints.push_back(motor.joint);
}

JointSet legs_of(const PlanarModel& model) {
  const JointGroups groups = joint_groups(model);

  JointSet legs = groups.front;
  add_all(legs.bodies, groups.rear.bodies);
  legs.joints.clear();
  set_joints(model, legs);
  return legs;
}

/// The front or the rear legs alone: what is typical of all legs, of one side.
JointScope leg_side(const JointScope& legs, const std::string& side, Component where,
                    JointSet JointGroups::*which) {
  JointScope scope = legs;
  scope.prefix = side + "_leg";
  scope.link_prefix = side + "_leg_link";
  scope.caption = "the " + side + " legs' motor joints";
  scope.where = {where};
  scope.links_where = {where, Component::body};
  scope.side = side;
  scope.select = [which](const PlanarModel& model) { return joint_groups(model).*which; };
  return scope;
}

JointScope make_leg_scope() {
  JointScope legs;
  legs.prefix = "leg";
  legs.link_prefix = "leg_link";
  legs.caption = "the legs' motor joints";
  legs.where = {Component::rear_legs, Component::front_legs};
  legs.links_where = {Component::rear_legs, Component::front_legs, Component::body};
  legs.excited_by = {ExperimentKind::leap};
  legs.usual = {0.1, 10.0, 7e-5, 3.0};
  legs.select = legs_of;

  const JointScope front = leg_side(legs, "front", Component::front_legs, &JointGroups::front);
  const JointScope rear = leg_side(legs, "rear", Component::rear_legs, &JointGroups::rear);
  legs.parts = {front, rear};
  return legs;
}

JointScope make_tail_scope() {
  JointScope tail;
  tail.prefix = "tail";
  tail.link_prefix = "tail_link";
  tail.caption = "the tail's joint";
  tail.where = {Component::tail_transmission};
  tail.links_where = {Component::tail_transmission, Component::body};
  tail.excited_by = {ExperimentKind::leap, ExperimentKind::self_righting,
                     ExperimentKind::tail_bench};
  tail.usual = {0.2, 10.0, 7e-5, 12.0};
  tail.select = [](const PlanarModel& model) { return joint_groups(model).tail; };
  return tail;
}

/// Links are bodies of the robot, whoever's joint carries them; a pendulum's are its body.
JointScope make_other_scope() {
  JointScope other;
  other.prefix = "joint";
  other.link_prefix = "link";
  other.caption = "the joints";
  other.where = {Component::actuation};
  other.links_where = {Component::body};
  other.excited_by = {ExperimentKind::pendulum};
  other.usual = {0.3, 5.0, 5e-3, 12.0};
  other.select = [](const PlanarModel& model) { return joint_groups(model).other; };
  return other;
}

}  // namespace

JointGroups joint_groups(const PlanarModel& model) {
  JointGroups groups;
  groups.tail.bodies = tail_bodies(model);

  double front_x = -kInfinity, rear_x = kInfinity;
  for (const model::PlanarPoint& foot : model.feet) {
    front_x = std::max(front_x, root_x(model, foot));
    rear_x = std::min(rear_x, root_x(model, foot));
  }
  for (const model::PlanarPoint& foot : model.feet) {
    const bool front = front_x > rear_x && root_x(model, foot) > 0.5 * (front_x + rear_x);
    add_all((front ? groups.front : groups.rear).bodies, leg_bodies(model, foot));
  }

  for (int b = 1; b < static_cast<int>(model.bodies.size()); ++b) {
    const bool grouped = contains(groups.tail.bodies, b) || contains(groups.front.bodies, b) ||
                         contains(groups.rear.bodies, b);
    if (!grouped) groups.other.bodies.push_back(b);
  }

  for (JointSet* set : {&groups.tail, &groups.front, &groups.rear, &groups.other})
    set_joints(model, *set);
  return groups;
}

const JointScope& tail_scope() {
  static const JointScope scope = make_tail_scope();
  return scope;
}

const JointScope& leg_scope() {
  static const JointScope scope = make_leg_scope();
  return scope;
}

const JointScope& other_scope() {
  static const JointScope scope = make_other_scope();
  return scope;
}

JointScope one_joint(const JointScope& scope, const std::string& joint) {
  JointScope one = scope;
  one.prefix = joint;
  one.link_prefix = joint + "_link";
  one.caption = "joint " + joint;
  one.parts.clear();
  one.select = [joint](const PlanarModel& model) {
    const int motor = model.motor_index(joint);
    if (motor < 0) return JointSet{};

    JointSet set{{joint}, {model.motors[motor].body}};
    add_carried(model, set.bodies);
    return set;
  };
  return one;
}

}  // namespace jaculus::effects
