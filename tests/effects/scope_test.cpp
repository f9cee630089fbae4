// Which joints an effect acts on: groups derived from the model, parts of the legs, one joint.

#include "effects/scope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "experiments.h"
#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "support/sample_models.h"

namespace jaculus::effects {
namespace {

using test::tailed;
using Names = std::vector<std::string>;

TEST(JointGroups, AreDerivedFromTheModel) {
  const JointGroups groups = joint_groups(tailed());
  EXPECT_EQ(groups.tail.joints, Names{"tail"});
  EXPECT_EQ(groups.front.joints, (Names{"front_a", "front_b"}));
  EXPECT_EQ(groups.rear.joints, (Names{"rear_a", "rear_b"}));
  EXPECT_TRUE(groups.other.joints.empty());

  // A tail that is held is no joint any more; its drag stays.
  const JointGroups held = joint_groups(model::lock(tailed(), "tail", 0.0));
  EXPECT_TRUE(held.tail.joints.empty());
  EXPECT_EQ(held.front.joints.size(), 2u);
}

TEST(JointGroups, OfEveryModelShareNoJoint) {
  for (const test_support::NamedModel& sample : test_support::sample_models()) {
    const JointGroups groups = joint_groups(sample.model);
    EXPECT_EQ(groups.tail.joints.size() + groups.front.joints.size() + groups.rear.joints.size() +
                  groups.other.joints.size(),
              sample.model.motors.size())
        << sample.name;
  }
}

TEST(OneJoint, IsThatJointAndWhatItCarries) {
  const model::PlanarModel& model = test::two_joints().plant.model;
  const JointSet shoulder = one_joint(other_scope(), "shoulder").select(model);
  EXPECT_EQ(shoulder.joints, Names{"shoulder"});
  EXPECT_EQ(shoulder.bodies, (std::vector<int>{1, 2}));
  const JointSet elbow = one_joint(other_scope(), "elbow").select(model);
  EXPECT_EQ(elbow.joints, Names{"elbow"});
  EXPECT_EQ(elbow.bodies, std::vector<int>{2});
  EXPECT_TRUE(one_joint(other_scope(), "wrist").select(model).joints.empty());
}

TEST(OneJoint, LeavesTheOtherAlone) {
  const model::PlanarModel& model = test::two_joints().plant.model;
  for (const Effect& effect : effects_on(one_joint(other_scope(), "elbow"))) {
    simulation::Plant plant = simulation::nominal_plant(model);
    ASSERT_TRUE(effect.applies(model)) << effect.name;
    effect.apply(effect.probed(), plant);
    EXPECT_TRUE(effect.name.starts_with("elbow_")) << effect.name;
    for (const simulation::JointFriction& friction : plant.friction)
      EXPECT_EQ(friction.joint, "elbow");
    for (const simulation::Transmission& transmission : plant.transmissions)
      EXPECT_EQ(transmission.joint, "elbow");
    EXPECT_EQ(plant.model.motors[0].rotor_inertia, model.motors[0].rotor_inertia) << effect.name;
    EXPECT_EQ(plant.model.bodies[1].mass, model.bodies[1].mass) << effect.name;
    EXPECT_FALSE(plant.sensing.offset.contains("shoulder")) << effect.name;
    EXPECT_FALSE(plant.sensing.scale.contains("shoulder")) << effect.name;
  }
}

/// What an effect can do to one joint and its link, as numbers.
std::vector<double> at_joint(const simulation::Plant& plant, const std::string& joint) {
  std::vector<double> values;
  for (const simulation::JointFriction& f : plant.friction)
    if (f.joint == joint)
      values.insert(values.end(), {f.coulomb, f.viscous, f.stribeck, f.stribeck_rate, f.load,
                                   f.positive, f.negative, f.load_stribeck, f.load_stribeck_rate});
  const auto offset = plant.actuation.torque_offset.find(joint);
  values.push_back(offset == plant.actuation.torque_offset.end() ? 0.0 : offset->second);
  for (const simulation::Transmission& t : plant.transmissions)
    if (t.joint == joint) values.insert(values.end(), {t.compliance, t.damping_ratio, t.play});
  const model::PlanarMotor& motor = plant.model.motors[plant.model.motor_index(joint)];
  const model::PlanarBody& link = plant.model.bodies[motor.body];
  values.insert(values.end(), {motor.rotor_inertia, link.mass, link.inertia});
  return values;
}

TEST(Parts, OfAnEffectOnLegsAreItsFrontAndItsRear) {
  const simulation::Plant nominal = simulation::nominal_plant(tailed());
  int parted = 0;
  for (const Effect& effect : effect_catalogue()) {
    if (effect.parts.empty()) {
      EXPECT_EQ(in_parts(effect), std::vector<const Effect*>{&effect}) << effect.name;
      continue;
    }

    ++parted;
    simulation::Plant whole = nominal, front = nominal, rear = nominal;
    effect.apply(effect.probed(), whole);
    ASSERT_EQ(in_parts(effect).size(), 2u) << effect.name;
    in_parts(effect)[0]->apply(effect.probed(), front);
    in_parts(effect)[1]->apply(effect.probed(), rear);
    for (const char* joint : {"front_a", "front_b"}) {
      EXPECT_EQ(at_joint(front, joint), at_joint(whole, joint)) << effect.name;
      EXPECT_EQ(at_joint(rear, joint), at_joint(nominal, joint)) << effect.name;
    }
    for (const char* joint : {"rear_a", "rear_b"}) {
      EXPECT_EQ(at_joint(rear, joint), at_joint(whole, joint)) << effect.name;
      EXPECT_EQ(at_joint(front, joint), at_joint(nominal, joint)) << effect.name;
    }
    EXPECT_EQ(at_joint(whole, "tail"), at_joint(nominal, "tail")) << effect.name;
  }
  EXPECT_GT(parted, 0);
}

TEST(Parts, HaveTheParametersOfTheWhole) {
  for (const Effect& effect : effect_catalogue()) {
    for (const Effect& part : effect.parts) {
      EXPECT_TRUE(effect_faults(part).empty()) << part.name;
      EXPECT_EQ(part.nominal(), effect.nominal()) << part.name;
      EXPECT_EQ(part.probed(), effect.probed()) << part.name;
      EXPECT_EQ(part.excited_by, effect.excited_by) << part.name;
    }
    if (!effect.parts.empty()) {
      EXPECT_EQ(effect.parts[0].where.front(), Component::front_legs) << effect.name;
      EXPECT_EQ(effect.parts[1].where.front(), Component::rear_legs) << effect.name;
    }
  }
}

TEST(LegEffects, HaveAnEntryForEachMotor) {
  const simulation::Plant nominal = simulation::nominal_plant(tailed());
  for (const char* kind : {"leg_coulomb_friction", "leg_rotor_inertia", "torque_constant"}) {
    const std::vector<Effect> all = sized_for(*find_effect(kind), tailed(), {});
    const std::string name = std::string(kind) + "@rear_a";
    const auto own = std::find_if(all.begin(), all.end(),
                                  [&](const Effect& effect) { return effect.name == name; });
    ASSERT_NE(own, all.end()) << name;
    ASSERT_TRUE(own->joints) << name;
    EXPECT_EQ(own->joints(tailed()), Names{"rear_a"});
    EXPECT_FALSE(own->acts_in(Component::front_legs)) << name;
    simulation::Plant plant = nominal;
    own->apply(own->probed(), plant);
    for (const char* joint : {"front_a", "front_b", "rear_b", "tail"})
      EXPECT_EQ(at_joint(plant, joint), at_joint(nominal, joint)) << name;
    const auto strength = [](const simulation::Plant& p) {
      return p.model.motors[p.model.motor_index("rear_a")].torque_constant;
    };
    const bool moved = at_joint(plant, "rear_a") != at_joint(nominal, "rear_a") ||
                       strength(plant) != strength(nominal);
    EXPECT_TRUE(moved) << name;
  }
}

TEST(BaseEffects, ScaleWithTheBase) {
  // A bar of 0.1 m by 0.01 m half, with the spread of a uniform one; and twice as large and heavy.
  model::PlanarModel robot = tailed();
  robot.bodies[0].com = Vec2::Zero();
  for (const double size : {1.0, 2.0}) {
    robot.bodies[0].mass = 6.0 * size;
    robot.bodies[0].spread = size * Vec2(0.1, 0.01) / std::sqrt(3.0);
    const std::vector<Effect> shift = sized_for(*find_effect("com_shift"), robot, {});
    ASSERT_EQ(shift.size(), 1u);
    EXPECT_NEAR(shift[0].parameters[0].bounds.upper, 0.1 * size, 1e-12);
    EXPECT_NEAR(shift[0].parameters[1].bounds.lower, -0.01 * size, 1e-12);
    EXPECT_NEAR(shift[0].parameters[1].scale, 0.001 * size, 1e-12);
    const std::vector<Effect> payload = sized_for(*find_effect("payload"), robot, {});
    EXPECT_NEAR(payload[0].parameters[0].bounds.upper, 3.0 * size, 1e-12);
    EXPECT_NEAR(payload[0].parameters[2].bounds.upper, 0.1 * size, 1e-12);
  }

  // A thin plate still has a tenth of its length, and a payload stands about the centre of mass.
  robot.bodies[0].spread = Vec2(0.1, 0.0) / std::sqrt(3.0);
  robot.bodies[0].com = Vec2(0.25, 0.0);
  const std::vector<Effect> thin = sized_for(*find_effect("com_shift"), robot, {});
  EXPECT_NEAR(thin[0].parameters[1].bounds.upper, 0.01, 1e-12);
  const std::vector<Effect> ahead = sized_for(*find_effect("payload"), robot, {});
  EXPECT_TRUE(effect_faults(ahead[0]).empty());
  EXPECT_EQ(ahead[0].parameters[1].nominal, 0.25);
  EXPECT_NEAR(ahead[0].parameters[1].bounds.upper, 0.35, 1e-12);

  // No file that says along which axis: a square's, by the inertia.
  robot.bodies[0].spread.setZero();
  robot.bodies[0].mass = 2.0;
  robot.bodies[0].inertia = 4.0 * 0.01 / 3.0;
  const std::vector<Effect> shift = sized_for(*find_effect("com_shift"), robot, {});
  EXPECT_NEAR(shift[0].parameters[0].bounds.upper, 0.1, 1e-12);
  EXPECT_NEAR(shift[0].parameters[1].bounds.upper, 0.1, 1e-12);
}

TEST(LegEffects, OnLinksOfALoopHaveNone) {
  for (const Effect& effect : effect_catalogue())
    if (effect.name.starts_with("leg_link")) {
      EXPECT_EQ(sized_for(effect, tailed(), {}).size(), 1u) << effect.name;
    }
}

}  // namespace
}  // namespace jaculus::effects
