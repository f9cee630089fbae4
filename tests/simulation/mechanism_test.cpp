// The plant's own kinematics and mass matrix against those of the planner: two implementations of
// one physics.

#include "simulation/plant/mechanism.h"

#include <gtest/gtest.h>

#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/model/robot.h"
#include "simulation/support.h"
#include "support/random_state.h"
#include "support/sample_models.h"

namespace jaculus::simulation {
namespace {

using namespace test;

std::vector<test_support::NamedModel> models() {
  std::vector<test_support::NamedModel> all = test_support::sample_models();
  for (const char* name : {"minitaur", "minitaur_tail"})
    all.push_back({name, model::read_robot(model::find_robot(name, "")).planar});
  all.push_back({"minitaur_tail locked", model::lock(all.back().model, "tail", -1.5)});
  return all;
}

TEST(Mechanism, MassMatrixAndBiasAreThePlanners) {
  std::mt19937 rng(3);
  for (const auto& [name, model] : models()) {
    const dynamics::AbsoluteTree tree(model);
    dynamics::Motion motion(tree);
    detail::Mechanism mechanism(nominal_plant(model));
    const int n = model.size();
    for (int trial = 0; trial < 20; ++trial) {
      const auto state = test_support::random_state(model, rng);
      ASSERT_TRUE(dynamics::set_configuration(tree, state.q, motion)) << name;
      dynamics::set_rates(tree, state.v, motion);
      ASSERT_TRUE(mechanism.set(state.q.data(), state.v.data())) << name;
      const Matrix M = dynamics::mass_matrix(tree, motion);
      const Vector h = bias(tree, motion);
      std::vector<double> mass(detail::kMaxSize * detail::kMaxSize, kNaN),
          force(detail::kMaxSize, kNaN);
      mechanism.assemble(mass.data(), force.data());
      for (int j = 0; j < n; ++j) {
        EXPECT_NEAR(force[j], h[j], 1e-11 * (1.0 + h.cwiseAbs().maxCoeff())) << name;
        for (int i = j; i < n; ++i)
          EXPECT_NEAR(mass[j * detail::kMaxSize + i], M(i, j),
                      1e-13 * (1.0 + M.cwiseAbs().maxCoeff()))
              << name;
      }
    }
  }
}

TEST(Mechanism, PointsAndJointsAreThePlanners) {
  std::mt19937 rng(4);
  for (const auto& [name, model] : models()) {
    const dynamics::AbsoluteTree tree(model);
    dynamics::Motion motion(tree);
    detail::Mechanism mechanism(nominal_plant(model));
    const auto state = test_support::random_state(model, rng);
    ASSERT_TRUE(dynamics::set_configuration(tree, state.q, motion)) << name;
    dynamics::set_rates(tree, state.v, motion);
    ASSERT_TRUE(mechanism.set(state.q.data(), state.v.data())) << name;
    for (int f = 0; f < count_of(model.feet); ++f) {
      detail::PointState point;
      mechanism.point(model.feet[f].body, model.feet[f].position, point);
      const int foot = f;
      EXPECT_LT((Vec2(point.px, point.pz) - dynamics::foot_position(tree, motion, foot)).norm(),
                1e-13)
          << name;
      EXPECT_LT((Vec2(point.vx, point.vz) - dynamics::foot_velocity(tree, motion, foot)).norm(),
                1e-12)
          << name;
      const Vec2 a = dynamics::point_acceleration(dynamics::foot_point(tree, foot), motion,
                                                  Vector::Zero(model.size()));
      EXPECT_LT((Vec2(point.ax, point.az) - a).norm(), 1e-10 * (1.0 + a.norm())) << name;
    }
    const Vector theta = dynamics::joint_positions(tree, state.q, motion),
                 rates = dynamics::joint_velocities(tree, state.v, motion);
    for (int b = 1; b < count_of(model.bodies); ++b) {
      detail::JointState joint;
      mechanism.joint(b, state.q.data(), state.v.data(), joint);
      EXPECT_NEAR(joint.value, theta[b], 1e-12) << name;
      EXPECT_NEAR(joint.rate, rates[b], 1e-11) << name;
    }
  }
}

}  // namespace
}  // namespace jaculus::simulation
