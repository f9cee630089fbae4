// Energy, momentum and its moment along the equations of motion: what motors, drag, feet and weight
// bring and nothing else. The rates come from central differences of totals that rigid_body.h
// computes without the equations.

#include <gtest/gtest.h>

#include "jaculus/components/equations.h"
#include "jaculus/dynamics/rigid_body.h"
#include "support/random_state.h"
#include "support/sample_models.h"

namespace jaculus::components {
namespace {

struct Totals {
  double energy, moment;
  Vec2 momentum;
};

Totals totals(const dynamics::AbsoluteTree& tree, const Vector& q, const Vector& v) {
  dynamics::Motion m(tree);
  EXPECT_TRUE(dynamics::set_configuration(tree, q, m));
  dynamics::set_rates(tree, v, m);
  return {dynamics::kinetic_energy(tree, m, v) + dynamics::potential_energy(tree, m),
          dynamics::angular_momentum(tree, m, Vec2::Zero()), dynamics::linear_momentum(tree, m)};
}

class Balances : public ::testing::TestWithParam<test_support::NamedModel> {
 protected:
  const model::PlanarModel& model() const { return GetParam().model; }
  std::vector<int> feet() const {
    std::vector<int> all;
    for (int f = 0; f < count_of(model().feet); ++f) all.push_back(f);
    return all;
  }
  /// Totals' rates of change at p, along its rates and accelerations.
  Totals rates(const Equations& eq, const EquationsPoint& p) const {
    const double h = 1e-6;
    const Totals plus = totals(eq.tree(), p.q + h * p.v, p.v + h * p.a);
    const Totals minus = totals(eq.tree(), p.q - h * p.v, p.v - h * p.a);
    return {(plus.energy - minus.energy) / (2 * h), (plus.moment - minus.moment) / (2 * h),
            (plus.momentum - minus.momentum) / (2 * h)};
  }
};

TEST_P(Balances, PowerIsThatOfMotorsDragAndFeet) {
  const Equations eq(model());
  const dynamics::AbsoluteTree& tree = eq.tree();
  std::mt19937 rng(17);
  for (int trial = 0; trial < 10; ++trial) {
    const test_support::RandomState s = test_support::random_state(model(), rng);
    const Vector u = 3.0 * Vector::Random(eq.inputs());
    EquationsPoint p(eq, trial % 2 == 0 ? std::vector<int>{} : feet());
    ASSERT_TRUE(eq.evaluate(s.q, s.v, u, p));
    double power = s.v.dot(tree.input_map * u) + eq.drag_power(p);
    // held without acceleration, but moving at these rates
    for (int k = 0; k < count_of(p.feet); ++k)
      power += p.force.segment<2>(2 * k).dot(dynamics::foot_velocity(tree, p.motion, p.feet[k]));
    EXPECT_NEAR(rates(eq, p).energy, power, 1e-6 * (1.0 + std::abs(power) + p.a.norm()));
  }
}

TEST_P(Balances, MomentumIsThatOfWeightDragAndFeet) {
  if (!model().base_free[0] || !model().base_free[1] || !model().base_free[2])
    GTEST_SKIP() << "the base is held";
  const Equations eq(model());
  const dynamics::AbsoluteTree& tree = eq.tree();
  std::mt19937 rng(18);
  for (int trial = 0; trial < 10; ++trial) {
    const test_support::RandomState s = test_support::random_state(model(), rng);
    EquationsPoint p(eq, trial % 2 == 0 ? std::vector<int>{} : feet());
    ASSERT_TRUE(eq.evaluate(s.q, s.v, 3.0 * Vector::Random(eq.inputs()), p));
    const Vec2 weight(0.0, -tree.total_mass * tree.gravity),
        com = dynamics::centre_of_mass(tree, p.motion);
    Vec2 force = weight + eq.drag_force(p);
    double moment = eq.drag_moment(p) - com.x() * weight.y();
    for (int k = 0; k < count_of(p.feet); ++k) {
      const Vec2 f = p.force.segment<2>(2 * k),
                 at = dynamics::foot_position(tree, p.motion, p.feet[k]);
      force += f;
      moment += at.y() * f.x() - at.x() * f.y();
    }
    const Totals rate = rates(eq, p);
    EXPECT_LT((rate.momentum - force).norm(), 1e-6 * (1.0 + force.norm() + p.a.norm()));
    EXPECT_NEAR(rate.moment, moment, 1e-6 * (1.0 + std::abs(moment) + p.a.norm()));
  }
}

/// In still air drag only takes.
TEST_P(Balances, DragDissipatesInStillAir) {
  model::PlanarModel still = model();
  if (still.drags.empty()) GTEST_SKIP() << "no tail";
  for (model::PlanarDrag& drag : still.drags) drag.wind_W.setZero();
  const Equations eq(still, 0.0);
  std::mt19937 rng(19);
  for (int trial = 0; trial < 50; ++trial) {
    const test_support::RandomState s = test_support::random_state(still, rng);
    EquationsPoint p(eq, {});
    ASSERT_TRUE(eq.evaluate(s.q, s.v, Vector::Zero(eq.inputs()), p));
    EXPECT_LT(eq.drag_power(p), 0.0);
  }
}

/// The equations and the free functions of rigid_body.h give the same accelerations and forces.
TEST_P(Balances, EquationsAgreeWithForwardDynamics) {
  model::PlanarModel airless = model();
  airless.drags.clear();
  const Equations eq(airless);
  std::mt19937 rng(20);
  for (int trial = 0; trial < 10; ++trial) {
    const test_support::RandomState s = test_support::random_state(airless, rng);
    const Vector u = 3.0 * Vector::Random(eq.inputs());
    EquationsPoint p(eq, trial % 2 == 0 ? std::vector<int>{} : feet());
    ASSERT_TRUE(eq.evaluate(s.q, s.v, u, p));
    const dynamics::ContactSolution x =
        dynamics::forward_dynamics(eq.tree(), p.motion, eq.tree().input_map * u, p.feet);
    ASSERT_TRUE(x.ok);
    EXPECT_LT((x.motion - p.a).norm(), 1e-10 * (1.0 + p.a.norm()));
    EXPECT_LT((x.force - p.force).norm(), 1e-10 * (1.0 + p.force.norm()));
  }
}

INSTANTIATE_TEST_SUITE_P(Models, Balances, ::testing::ValuesIn(test_support::sample_models()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace jaculus::components
