#pragma once
// Which joints of a robot an effect acts on: a scope. Derived from the model alone.
//   tail         joints that carry a body with drag, directly or further up its chain
//   front, rear  joints on the chain of a foot or on a chain that a loop closes with it; front is
//                the foot whose chain leaves the base at the larger x (a single foot is a rear one)
//   other        all the rest (a pendulum's joint)
//   one joint    of these, by name

#include <functional>
#include <string>
#include <vector>

#include "jaculus/effects/effect.h"

namespace jaculus::effects {

/// Joints of a scope in a robot, and what lies beyond them.
struct JointSet {
  std::vector<std::string> joints;  ///< with a motor, in the model's order
  std::vector<int> bodies;          ///< that these joints carry, and all beyond
};

struct JointGroups {
  JointSet tail, front, rear, other;
};

JointGroups joint_groups(const model::PlanarModel& model);

/// Typical sizes at a joint, of which priors are made.
struct UsualSizes {
  double torque = 0.0;        ///< of friction at the joint [N m, N where it slides]
  double rate = 0.0;          ///< of the joint [rad/s, m/s]
  double inertia = 0.0;       ///< before the gear [kg m^2, kg]
  double strength = 0.0;      ///< of the joints that these sizes are of [N m, N]
  double torque_ratio = 1.0;  ///< of a robot's joints to those [-]
  double rate_ratio = 1.0;    ///< [-]
};

/// Joints that share one effect of a kind: how it is called there, and what is typical of them.
struct JointScope {
  std::string prefix;                  ///< opens the name of an effect on the joints: "tail", "leg"
  std::string link_prefix;             ///< and of one on the links beyond them: "tail_link"
  std::string caption;                 ///< "the tail's joint"
  std::vector<Component> where;        ///< an effect on the joints, the main one first
  std::vector<Component> links_where;  ///< an effect on the links
  std::vector<trajectory::ExperimentKind> excited_by;
  UsualSizes usual;
  /// The scope's joints in a robot; none where it has no such joint.
  std::function<JointSet(const model::PlanarModel&)> select;
  std::string side;               ///< "front" or "rear", of a part of the legs
  std::vector<JointScope> parts;  ///< front and rear legs, of the legs
};

const JointScope& tail_scope();
const JointScope& leg_scope();
const JointScope& other_scope();
/// One joint of a scope. An effect is then called by the joint's name.
JointScope one_joint(const JointScope& scope, const std::string& joint);

/// The rate below which dry friction holds a motor's joint [rad/s, m/s where it slides]: slow
/// joints rest below slower rates. It is the joint's own, whatever law acts there: by two rates the
/// same friction would be two, and data would tell them apart.
double rest_rate(const model::PlanarModel& model, const std::string& joint,
                 const JointRates& rates);

/// Largest torque of a joint: its motor's limit behind the gear, else what holds the links that it
/// carries level [N m, N where it slides].
double joint_strength(const model::PlanarModel& model, const std::string& joint);

/// A scope with the usual sizes of a robot's joints in it. With s the mean of their strengths over
/// that of the joints for which the scope's numbers were chosen,
///   torque' = s torque;   rate' = mean of the stated rates, else 0.1 m/s where joints slide, else
///   as it was;
///   inertia' = s inertia of legs and tails; of other joints 1/30 of the mean of what the
///   links have about the joint, by the gear squared (as 5e-3 kg m^2 of an arm of 0.15).
JointScope sized_scope(const JointScope& scope, const model::PlanarModel& model,
                       const JointRates& rates);

/// Whether all joints of a scope slide in a robot that has one.
bool all_slide(const JointScope& scope, const model::PlanarModel& model);

/// Replaces units of turning joints by those of sliding ones.
void use_sliding_units(Effect& effect);

/// Every effect of the catalogue that acts on joints or their links, made for a scope.
std::vector<Effect> effects_on(const JointScope& scope);

}  // namespace jaculus::effects
