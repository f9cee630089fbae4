// The plant's own kinematics and mass matrix against those of the planner: two implementations of
// one physics.

#include "simulation/plant/mechanism.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/model/robot.h"
#include "simulation/plant/inertia.h"
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

/// A chain of equal links that hangs from a fixed base.
model::PlanarModel chain(int links) {
  std::vector<model::PlanarBody> bodies;
  std::vector<std::string> joints;
  for (int k = 0; k < links; ++k) {
    joints.push_back("joint_" + std::to_string(k));
    bodies.push_back(
        link(joints.back(), k, Vec2(0.0, k > 0 ? -0.2 : 0.0), 0.5, Vec2(0.01, -0.1), 2e-3));
  }
  return test_support::on_fixed_base(std::move(bodies), joints);
}

TEST(Inertia, RefusesALinkThatWeighsNothing) {
  model::PlanarModel model = chain(3);
  detail::Inertia inertia;
  model.bodies.back().mass = model.bodies.back().inertia = 0.0;
  detail::Mechanism mechanism(nominal_plant(model));
  const Vector q = Vector::Zero(3), v = Vector::Zero(3);
  ASSERT_TRUE(mechanism.set(q.data(), v.data()));
  EXPECT_FALSE(inertia.set(mechanism));
}

TEST(Inertia, IsTheMassMatrixOfFewJointsAndOfMany) {
  std::mt19937 rng(6);
  std::vector<int> sizes(16);
  std::iota(sizes.begin(), sizes.end(), 1);
  std::shuffle(sizes.begin(), sizes.end(), rng);
  detail::Inertia inertia;  // of one size after the other
  for (const int n : sizes) {
    const model::PlanarModel model = chain(n);
    detail::Mechanism mechanism(nominal_plant(model));
    const auto state = test_support::random_state(model, rng);
    ASSERT_TRUE(mechanism.set(state.q.data(), state.v.data())) << n;
    Matrix M = Matrix::Zero(detail::kMaxSize, n);
    Vector unused(detail::kMaxSize);
    mechanism.assemble(M.data(), unused.data());
    M = Matrix(M.topRows(n).selfadjointView<Eigen::Lower>());

    ASSERT_TRUE(inertia.set(mechanism)) << n;
    for (int i = 0; i < n; ++i) EXPECT_NEAR(inertia.diagonal(i), M(i, i), 1e-13 * M(0, 0)) << n;
    const Vector x = Vector::LinSpaced(n, -1.0, 2.0);
    Vector solved = M * x;
    inertia.forward(solved.data());
    inertia.backward(solved.data());
    const double condition = M.norm() * M.inverse().norm();
    EXPECT_LT((solved - x).norm(), 1e-14 * condition * x.norm()) << n;
  }
}

}  // namespace
}  // namespace jaculus::simulation
