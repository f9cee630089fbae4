// The plant's own kinematics and mass matrix against those of the planner: two implementations of one physics.

#include "simulation/mechanism.h"

#include <gtest/gtest.h>

#include "jaculus/components/equations.h"
#include "jaculus/model/robot.h"
#include "simulation/plant_equations.h"
#include "simulation/support.h"
#include "support/random_state.h"
#include "support/sample_models.h"

namespace jaculus {
namespace {

using namespace test;

std::vector<test_support::NamedModel> models() {
  std::vector<test_support::NamedModel> all = test_support::sample_models();
  for (const char* name : {"minitaur", "minitaur_tail"}) all.push_back({name, read_robot(find_robot(name, "")).planar});
  all.push_back({"minitaur_tail locked", lock(all.back().model, "tail", -1.5)});
  return all;
}

TEST(Mechanism, MassMatrixAndBiasAreThePlanners) {
  std::mt19937 rng(3);
  for (const auto& [name, model] : models()) {
    const AbsoluteTree tree(model);
    Motion motion(tree);
    detail::Mechanism mechanism(nominal_plant(model));
    const int n = model.size();
    for (int trial = 0; trial < 20; ++trial) {
      const auto state = test_support::random_state(model, rng);
      ASSERT_TRUE(set_configuration(tree, state.q, motion)) << name;
      set_rates(tree, state.v, motion);
      ASSERT_TRUE(mechanism.set(state.q.data(), state.v.data())) << name;
      const Matrix M = mass_matrix(tree, motion);
      const Vector h = bias(tree, motion);
      std::vector<double> mass(detail::kMaxSize * detail::kMaxSize, kNaN), force(detail::kMaxSize, kNaN);
      mechanism.assemble(mass.data(), force.data());
      for (int j = 0; j < n; ++j) {
        EXPECT_NEAR(force[static_cast<size_t>(j)], h[j], 1e-11 * (1.0 + h.cwiseAbs().maxCoeff())) << name;
        for (int i = j; i < n; ++i)
          EXPECT_NEAR(mass[static_cast<size_t>(j * detail::kMaxSize + i)], M(i, j),
                      1e-13 * (1.0 + M.cwiseAbs().maxCoeff()))
              << name;
      }
    }
  }
}

TEST(Mechanism, PointsAndJointsAreThePlanners) {
  std::mt19937 rng(4);
  for (const auto& [name, model] : models()) {
    const AbsoluteTree tree(model);
    Motion motion(tree);
    detail::Mechanism mechanism(nominal_plant(model));
    const auto state = test_support::random_state(model, rng);
    ASSERT_TRUE(set_configuration(tree, state.q, motion)) << name;
    set_rates(tree, state.v, motion);
    ASSERT_TRUE(mechanism.set(state.q.data(), state.v.data())) << name;
    for (size_t f = 0; f < model.feet.size(); ++f) {
      detail::PointState point;
      mechanism.point(model.feet[f].body, model.feet[f].position, point);
      const int foot = static_cast<int>(f);
      EXPECT_LT((Vec2(point.px, point.pz) - foot_position(tree, motion, foot)).norm(), 1e-13) << name;
      EXPECT_LT((Vec2(point.vx, point.vz) - foot_velocity(tree, motion, foot)).norm(), 1e-12) << name;
      const Vec2 a = point_acceleration(foot_point(tree, foot), motion, Vector::Zero(model.size()));
      EXPECT_LT((Vec2(point.ax, point.az) - a).norm(), 1e-10 * (1.0 + a.norm())) << name;
    }
    const Vector theta = joint_positions(tree, state.q, motion), rates = joint_velocities(tree, state.v, motion);
    for (int b = 1; b < static_cast<int>(model.bodies.size()); ++b) {
      detail::JointState joint;
      mechanism.joint(b, state.q.data(), state.v.data(), joint);
      EXPECT_NEAR(joint.value, theta[b], 1e-12) << name;
      EXPECT_NEAR(joint.rate, rates[b], 1e-11) << name;
    }
  }
}

TEST(Mechanism, AccelerationsAndForcesInStanceAreThePlanners) {
  const PlanarModel model = read_robot(find_robot("minitaur_tail", "")).planar;
  const Plant plant = nominal_plant(model);
  Controller c = no_controller();
  c.after_end = AfterEnd::repeat;
  c.reference.time = Vector::Zero(1);
  const auto motors = static_cast<Eigen::Index>(model.motors.size());
  c.reference.feedforward = Matrix::Constant(motors, 1, 0.3);
  Vector u(motors);
  for (Eigen::Index m = 0; m < motors; ++m) {
    const PlanarMotor& motor = model.motors[static_cast<size_t>(m)];
    c.reference.motors.push_back(motor.joint);
    u[m] = 0.3 * motor.gear * motor.efficiency;
  }
  detail::PlantEquations fast(plant, c);
  const Equations slow(model, plant.drag_smoothing);
  EquationsPoint point(slow, {0, 1});
  std::mt19937 rng(5);
  std::vector<double> y(static_cast<size_t>(fast.states())), dydt(y.size());
  for (int trial = 0; trial < 10; ++trial) {
    const auto state = test_support::random_state(model, rng);
    std::copy(state.q.begin(), state.q.end(), y.begin());
    std::copy(state.v.begin(), state.v.end(), y.begin() + model.size());
    ASSERT_TRUE(slow.evaluate(state.q, state.v, u, point));
    fast.modes = {detail::Touch::stick, detail::Touch::stick};
    fast.update(0.0, y.data());
    ASSERT_TRUE(fast.evaluate(0.0, y.data(), dydt.data()));
    for (int i = 0; i < model.size(); ++i)
      EXPECT_NEAR(dydt[static_cast<size_t>(model.size() + i)], point.a[i],
                  1e-8 * (1.0 + point.a.cwiseAbs().maxCoeff()));
    for (int i = 0; i < 4; ++i)
      EXPECT_NEAR(fast.lambda[static_cast<size_t>(i)], point.force[i],
                  1e-8 * (1.0 + point.force.cwiseAbs().maxCoeff()));
  }
}

}  // namespace
}  // namespace jaculus
