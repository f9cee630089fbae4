// The testbed's effects that lean one way: torque beside the motor's, friction by direction, a base
// that stands aslant. Batches do not draw them.

#include "testbed/effect_rows.h"

namespace jaculus::testbed {
namespace {

/// Joints that share an effect.
struct Group {
  std::string prefix;
  std::string component;
  double Changes::*offset;
  DryFriction Changes::*friction;
  const Experiments& experiments;
  double largest;  ///< [N m]
};

void add_group(EffectRows& rows, const Group& g) {
  const double largest = round_figure(g.largest);
  rows.add(g.prefix + "_torque_offset", "a torque that no log shows", g.component,
           {{"torque", "N m", 0.0, -largest, largest}}, g.experiments,
           [member = g.offset](const Values& v, Changes& c) { c.*member = v[0]; })
      .by_name_only = true;
  rows.add(g.prefix + "_directional_friction", "dry friction, more one way than the other",
           g.component,
           {{"torque", "N m", 0.0, 0.0, largest}, drawn("asymmetry", "-", 0.5, -1.0, 1.0)},
           g.experiments,
           [member = g.friction](const Values& v, Changes& c) {
             (c.*member).positive = v[0] * (1.0 + v[1]);
             (c.*member).negative = v[0] * (1.0 - v[1]);
           })
      .by_name_only = true;
}

}  // namespace

void add_bias(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  if (!s.tail.joints.empty()) {
    add_group(rows, {"tail", "tail_transmission", &Changes::tail_torque_offset,
                     &Changes::tail_friction, kTail, s.tail.torque / 6.0});
  }
  if (!s.legs.joints.empty()) {
    add_group(rows, {"leg", "", &Changes::leg_torque_offset, &Changes::leg_friction, kLeap,
                     s.legs.torque / 5.0});
  } else if (!s.other.joints.empty()) {
    add_group(rows, {"joint", "actuation", &Changes::leg_torque_offset, &Changes::leg_friction,
                     kPendulum, s.other.torque / 5.0});
  }

  rows.add("base_tilt", "a base that is held aslant", "body", {{"angle", "rad", 0.0, -0.2, 0.2}},
           kHeld, [](const Values& v, Changes& c) { c.base_tilt = v[0]; })
      .by_name_only = true;
}

}  // namespace jaculus::testbed
