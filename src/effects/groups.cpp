#include "effects/groups.h"

#include <fmt/format.h>

#include <algorithm>

namespace jaculus::effects {
namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

bool contains(const std::vector<int>& list, int value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

/// Bodies from `body` towards the base, the base aside.
std::vector<int> chain(const PlanarModel& model, int body) {
  std::vector<int> bodies;
  for (; body > 0; body = model.bodies[at(body)].parent) bodies.push_back(body);
  return bodies;
}

/// The chain of a foot and those that loops close with it.
std::vector<int> leg_bodies(const PlanarModel& model, const PlanarPoint& foot) {
  std::vector<int> leg = chain(model, foot.body);
  for (std::size_t size = 0; size != leg.size();) {
    size = leg.size();
    for (const PlanarLoop& loop : model.loops) {
      for (const auto& [from, to] : {std::pair(loop.body_a, loop.body_b), std::pair(loop.body_b, loop.body_a)}) {
        if (!contains(leg, from)) continue;
        for (const int body : chain(model, to)) {
          if (!contains(leg, body)) leg.push_back(body);
        }
      }
    }
  }
  return leg;
}

/// Where a foot's chain leaves the base [m].
double root_x(const PlanarModel& model, const PlanarPoint& foot) {
  const std::vector<int> bodies = chain(model, foot.body);
  return bodies.empty() ? foot.position.x() : model.bodies[at(bodies.back())].origin.x();
}

std::vector<std::string> motors_on(const PlanarModel& model, const std::vector<int>& bodies) {
  std::vector<std::string> joints;
  for (const PlanarMotor& motor : model.motors) {
    if (contains(bodies, motor.body)) joints.push_back(motor.joint);
  }
  return joints;
}

void add_all(std::vector<int>& to, const std::vector<int>& from) {
  for (const int body : from) {
    if (!contains(to, body)) to.push_back(body);
  }
}

/// Bodies of the tails: those with drag, what lies between them and the base, and what they carry.
std::vector<int> tail_bodies(const PlanarModel& model) {
  std::vector<int> tail;
  for (const PlanarDrag& drag : model.drags) add_all(tail, chain(model, drag.body));
  for (int b = 1; b < static_cast<int>(model.bodies.size()); ++b) {
    if (contains(tail, model.bodies[at(b)].parent)) add_all(tail, {b});
  }
  return tail;
}

}  // namespace

JointGroups joint_groups(const PlanarModel& model) {
  JointGroups groups;
  groups.tail_bodies = tail_bodies(model);
  double front_x = -kInfinity, rear_x = kInfinity;
  for (const PlanarPoint& foot : model.feet) {
    front_x = std::max(front_x, root_x(model, foot));
    rear_x = std::min(rear_x, root_x(model, foot));
  }
  for (const PlanarPoint& foot : model.feet) {
    const bool front = front_x > rear_x && root_x(model, foot) > 0.5 * (front_x + rear_x);
    add_all(front ? groups.front_bodies : groups.rear_bodies, leg_bodies(model, foot));
  }
  for (int b = 1; b < static_cast<int>(model.bodies.size()); ++b) {
    if (contains(groups.tail_bodies, b) || contains(groups.front_bodies, b) || contains(groups.rear_bodies, b)) {
      continue;
    }
    groups.other_bodies.push_back(b);
  }
  groups.tail = motors_on(model, groups.tail_bodies);
  groups.front = motors_on(model, groups.front_bodies);
  groups.rear = motors_on(model, groups.rear_bodies);
  groups.other = motors_on(model, groups.other_bodies);
  return groups;
}

const Group& tail_group() {
  static const Group group = {"tail",
                              "tail_link",
                              "the tail's joint",
                              Component::tail_transmission,
                              {},
                              {"leap", "self_righting", "tail_bench"},
                              0.2,
                              10.0,
                              7e-5};
  return group;
}

const Group& leg_group() {
  static const Group group = {
      "leg", "leg_link", "the legs' motor joints", Component::rear_legs, {Component::front_legs}, {"leap"}, 0.1,
      10.0,  7e-5};
  return group;
}

const Group& other_group() {
  static const Group group = {"joint", "link", "the joints", Component::actuation, {}, {"pendulum"}, 0.3, 5.0, 5e-3};
  return group;
}

std::vector<std::string> joints_of(const Group& group, const PlanarModel& model) {
  const JointGroups groups = joint_groups(model);
  if (&group == &tail_group()) return groups.tail;
  if (&group == &other_group()) return groups.other;
  std::vector<std::string> legs;
  for (const PlanarMotor& motor : model.motors) {
    const auto in = [&](const std::vector<std::string>& list) {
      return std::find(list.begin(), list.end(), motor.joint) != list.end();
    };
    if (in(groups.front) || in(groups.rear)) legs.push_back(motor.joint);
  }
  return legs;
}

std::vector<int> bodies_of(const Group& group, const PlanarModel& model) {
  const JointGroups groups = joint_groups(model);
  if (&group == &tail_group()) return groups.tail_bodies;
  if (&group == &other_group()) return groups.other_bodies;
  std::vector<int> legs = groups.front_bodies;
  add_all(legs, groups.rear_bodies);
  return legs;
}

std::function<bool(const PlanarModel&)> has_joints(const Group& group) {
  return [&group](const PlanarModel& model) { return !joints_of(group, model).empty(); };
}

bool base_moves(const PlanarModel& model) { return model.base_free[0] || model.base_free[1] || model.base_free[2]; }

std::string text_of(double value) { return fmt::format("{}", value); }
std::string text_of(const Vec2& value) { return fmt::format("[{}, {}]", value.x(), value.y()); }

}  // namespace jaculus::effects
