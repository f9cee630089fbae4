// The testbed's effects at one joint of several: a name of the diagnosis' catalogue, an @ and the
// planar joint. Tails are a joint of their own already.

#include "testbed/effect_rows.h"

namespace jaculus::testbed {
namespace {

/// One joint of a robot, as rows need it.
struct OneJoint {
  std::string joint;
  std::string prefix;     ///< of the catalogue's names: "leg", "joint"
  std::string component;  ///< where the joint is
  const Experiments& experiments;
  JointSize size;
  bool winding = false;  ///< whether the motor has one
  bool rotor = false;    ///< whether its rotor has inertia
};

using Apply = std::function<void(const Values&, Changes&)>;

/// A row "NAME@JOINT"; `component` where it is not that of the joint.
void add_at(EffectRows& rows, const OneJoint& at, const std::string& name,
            const std::string& caption, std::vector<BenchParameter> parameters, Apply apply,
            const std::string& component = "") {
  BenchEffect& row = rows.add(name + "@" + at.joint, caption + " at " + at.joint + " alone",
                              component.empty() ? at.component : component, std::move(parameters),
                              at.experiments, std::move(apply));
  row.joint = at.joint;
}

/// As of all joints of a group, in shares of this joint's torque.
void add_friction_at(EffectRows& rows, const OneJoint& at) {
  const std::string joint = at.joint;
  const double torque = at.size.torque;
  add_at(rows, at, at.prefix + "_coulomb_friction", "dry friction",
         {strength("torque", "N m", torque / 600.0, torque / 5.0)},
         [joint](const Values& v, Changes& c) { c.joint_friction[joint].coulomb += v[0]; });
  add_at(rows, at, at.prefix + "_viscous_friction", "friction in proportion to speed",
         {strength("coefficient", "N m s/rad", torque / 1e4, torque / 50.0)},
         [joint](const Values& v, Changes& c) { c.joint_friction[joint].viscous += v[0]; });
  add_at(rows, at, at.prefix + "_load_friction", "friction in proportion to the motor's torque",
         {{"share", "-", 0.0, 0.005, 0.5}},
         [joint](const Values& v, Changes& c) { c.joint_friction[joint].load += v[0]; });
}

/// What leans one way; batches do not draw it.
void add_bias_at(EffectRows& rows, const OneJoint& at) {
  const std::string joint = at.joint;
  const double largest = round_figure(at.size.torque / 5.0);
  add_at(rows, at, at.prefix + "_torque_offset", "a torque that no log shows",
         {{"torque", "N m", 0.0, -largest, largest}},
         [joint](const Values& v, Changes& c) { c.joint_torque_offset[joint] += v[0]; });
  rows.all.back().by_name_only = true;
  add_at(rows, at, at.prefix + "_directional_friction", "dry friction, more one way",
         {{"torque", "N m", 0.0, 0.0, largest}, drawn("asymmetry", "-", 0.5, -1.0, 1.0)},
         [joint](const Values& v, Changes& c) {
           c.joint_friction[joint].positive += v[0] * (1.0 + v[1]);
           c.joint_friction[joint].negative += v[0] * (1.0 - v[1]);
         });
  rows.all.back().by_name_only = true;
}

void add_motor_at(EffectRows& rows, const OneJoint& at) {
  const std::string joint = at.joint;
  const double torque = at.size.motor_torque;
  add_at(rows, at, at.prefix + "_rotor_inertia", "a heavier rotor",
         {strength("inertia", "kg m^2", torque / 1.5e6, torque / 7.5e3)},
         [joint](const Values& v, Changes& c) { c.joint_rotor_inertia[joint] += v[0]; });

  if (!at.winding) return;
  add_at(
      rows, at, "torque_constant", "magnets stronger or weaker than stated",
      {{"scale", "-", 1.0, 0.6, 1.4}},
      [joint](const Values& v, Changes& c) { c.joint_torque_constant[joint] = v[0]; }, "actuation");
}

/// Only behind a rotor, which is all that the motor moves within the play, and where no pin closes
/// the chain, which settles with the play at a flank.
void add_play_at(EffectRows& rows, const OneJoint& at) {
  if (!at.rotor || at.prefix != "joint") return;
  const std::string joint = at.joint;
  add_at(rows, at, at.prefix + "_backlash", "dead band behind the gear",
         {{"play", "rad", 0.0, 0.001, 0.06}},
         [joint](const Values& v, Changes& c) { c.joint_play[joint] += v[0]; });
}

void add_encoder_at(EffectRows& rows, const OneJoint& at) {
  const std::string joint = at.joint;
  add_at(
      rows, at, at.prefix + "_offset", "the encoder is set wrong",
      {{"offset", "rad", 0.0, -0.1, 0.1}},
      [joint](const Values& v, Changes& c) { c.joint_offset[joint] += v[0]; }, "sensing");
}

OneJoint one_joint_of(const RobotFiles& files, const std::string& joint) {
  const Drive& drive = files.drives[files.sides_of(joint).front()];
  const bool leg = drive.limb != Limb::other;
  const std::string legs = drive.limb == Limb::front_leg ? "front_legs" : "rear_legs";
  return {joint,
          leg ? "leg" : "joint",
          leg ? legs : "actuation",
          leg ? kLeap : kPendulum,
          size_of(files, drive),
          !drive.motor.ideal(),
          drive.motor.rotor_inertia > 0.0};
}

}  // namespace

void add_one_joint(EffectRows& rows) {
  const Sizes& s = rows.sizes;
  std::vector<std::string> joints = s.legs.joints;
  joints.insert(joints.end(), s.other.joints.begin(), s.other.joints.end());
  if (joints.size() < 2) return;

  for (const std::string& joint : joints) {
    const OneJoint at = one_joint_of(rows.files, joint);
    add_friction_at(rows, at);
    add_bias_at(rows, at);
    add_motor_at(rows, at);
    add_play_at(rows, at);
    add_encoder_at(rows, at);
  }
}

}  // namespace jaculus::testbed
