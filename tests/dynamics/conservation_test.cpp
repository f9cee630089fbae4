// What must not change along a motion, integrated at tight tolerance.

#include <gtest/gtest.h>

#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "dynamics/planar_builder.h"
#include "jaculus/dynamics/rigid_body.h"
#include "support/sample_models.h"

namespace jaculus::dynamics {
namespace {

using State = std::vector<double>;
using Torque = std::function<Vector(double time)>;  ///< generalised force (n)

Vector head(const State& s, int n) { return Eigen::Map<const Vector>(s.data(), n); }
Vector rates(const State& s, int n) { return Eigen::Map<const Vector>(s.data() + n, n); }

Motion at(const AbsoluteTree& tree, const State& s) {
  Motion m(tree);
  EXPECT_TRUE(set_configuration(tree, head(s, tree.n), m));
  set_rates(tree, rates(s, tree.n), m);
  return m;
}

/// Integrates (q, v, work) to `duration` with `stance` held; the work of the generalised forces is
/// the last entry.
State integrate(const AbsoluteTree& tree, const Vector& q, const Vector& v, const Torque& torque,
                const std::vector<int>& stance, double duration) {
  namespace odeint = boost::numeric::odeint;
  State s(q.data(), q.data() + tree.n);
  s.insert(s.end(), v.data(), v.data() + tree.n);
  s.push_back(0.0);
  const auto rhs = [&](const State& x, State& dx, double t) {
    const Vector Q = torque(t), rate = rates(x, tree.n);
    const ContactSolution solution = forward_dynamics(tree, at(tree, x), Q, stance);
    ASSERT_TRUE(solution.ok);
    for (int i = 0; i < tree.n; ++i) {
      dx[i] = rate[i];
      dx[tree.n + i] = solution.motion[i];
    }
    dx.back() = Q.dot(rate);
  };
  odeint::integrate_adaptive(
      odeint::make_controlled<odeint::runge_kutta_fehlberg78<State>>(1e-13, 1e-13), rhs, s, 0.0,
      duration, 1e-3);
  return s;
}

double energy(const AbsoluteTree& tree, const State& s) {
  const Motion m = at(tree, s);
  return kinetic_energy(tree, m, rates(s, tree.n)) + potential_energy(tree, m);
}

State start(const AbsoluteTree& tree, const Vector& q, const Vector& v) {
  return integrate(
      tree, q, v, [&](double) { return Vector::Zero(tree.n); }, {}, 0.0);
}

/// Energy over ten seconds, and the return to rest after one period 4 sqrt(l/g) K(sin(amplitude /
/// 2)).
TEST(Conservation, PendulumEnergyAndPeriod) {
  const double length = 0.6, amplitude = 2.0;
  const AbsoluteTree tree(test_support::on_fixed_base(
      {test_support::link("arm", 0, Vec2::Zero(), 1.5, Vec2(0.0, -length), 0.0)}, {"arm"}));
  const auto none = [](double) { return Vector::Zero(1); };
  const Vector q{{amplitude}}, v{{0.0}};
  const double before = energy(tree, start(tree, q, v));
  EXPECT_NEAR(energy(tree, integrate(tree, q, v, none, {}, 10.0)), before, 1e-10);
  const double period =
      4.0 * std::sqrt(length / kGravity) * std::comp_ellint_1(std::sin(0.5 * amplitude));
  const State after = integrate(tree, q, v, none, {}, period);
  EXPECT_NEAR(after[0], amplitude, 1e-10);
  EXPECT_NEAR(after[1], 0.0, 1e-9);
}

struct Flight {
  AbsoluteTree tree;
  Vector q, v;
  Torque torque;
};

/// The leaper of the samples (five-bar leg, prismatic leg, tail), its motors working.
Flight leaper() {
  model::PlanarModel model;
  for (const test_support::NamedModel& m : test_support::sample_models())
    if (m.name == "Leaper") model = m.model;
  Flight f{AbsoluteTree(model), Vector::Zero(model.size()), Vector::Zero(model.size()), {}};
  f.q << 0.2, 0.6, 0.1, 1.3, 1.4, 0.2, 0.05, 0.3;
  f.v << 0.4, 2.0, -0.5, 0.4, -0.3, 0.6, 0.1, -1.5;
  const Matrix B = f.tree.input_map;
  f.torque = [B](double t) {
    const Vector u{
        {0.2 * std::sin(20.0 * t), -0.1, 0.3 * std::cos(15.0 * t), 0.1, 0.5 * std::sin(9.0 * t)}};
    return Vector(B * u);
  };
  return f;
}

TEST(Conservation, FlightIsBallisticAndKeepsAngularMomentum) {
  const Flight f = leaper();
  const double duration = 0.25;
  const State before = start(f.tree, f.q, f.v),
              after = integrate(f.tree, f.q, f.v, f.torque, {}, duration);
  const Motion m0 = at(f.tree, before), m1 = at(f.tree, after);
  const Vec2 fall(0.0, -kGravity), v0 = centre_of_mass_velocity(f.tree, m0);
  const Vec2 expected =
      centre_of_mass(f.tree, m0) + duration * v0 + 0.5 * duration * duration * fall;
  EXPECT_LT((centre_of_mass(f.tree, m1) - expected).norm(), 1e-11);
  EXPECT_LT((centre_of_mass_velocity(f.tree, m1) - v0 - duration * fall).norm(), 1e-11);
  EXPECT_NEAR(angular_momentum(f.tree, m1), angular_momentum(f.tree, m0), 1e-11);
  EXPECT_NEAR(energy(f.tree, after) - energy(f.tree, before), after.back(), 1e-10);
  EXPECT_GT(std::abs(after.back()), 1e-3);  // the motors did work
  // and everything moved
  EXPECT_GT((head(after, f.tree.n) - head(before, f.tree.n)).cwiseAbs().minCoeff(), 1e-4);
}

/// With one foot held (a start at rest) it stays, and the energy is still the motors' work: the
/// floor does none.
TEST(Conservation, StanceHoldsTheFootAndDoesNoWork) {
  const Flight f = leaper();
  for (int foot = 0; foot < 2; ++foot) {
    const Vector rest = Vector::Zero(f.tree.n);
    const State before = start(f.tree, f.q, rest),
                after = integrate(f.tree, f.q, rest, f.torque, {foot}, 0.1);
    const Motion m0 = at(f.tree, before), m1 = at(f.tree, after);
    EXPECT_LT((foot_position(f.tree, m1, foot) - foot_position(f.tree, m0, foot)).norm(), 1e-11);
    EXPECT_LT(foot_velocity(f.tree, m1, foot).norm(), 1e-11);
    EXPECT_NEAR(energy(f.tree, after) - energy(f.tree, before), after.back(), 1e-10);
    EXPECT_GT((centre_of_mass(f.tree, m1) - centre_of_mass(f.tree, m0)).norm(), 1e-3);
  }
}

}  // namespace
}  // namespace jaculus::dynamics
