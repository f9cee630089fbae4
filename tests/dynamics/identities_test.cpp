// Identities that hold for any robot at any state, on small robots with loops, prismatic joints and
// free or fixed bases.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "dynamics/plain_kinematics.h"
#include "jaculus/dynamics/rigid_body.h"
#include "support/random_state.h"
#include "support/sample_models.h"

namespace jaculus::dynamics {
namespace {

using test_support::NamedModel;
using test_support::RandomState;

class Identities : public ::testing::TestWithParam<NamedModel> {
 protected:
  const model::PlanarModel& model() const { return GetParam().model; }
  Motion at(const Vector& q, const Vector& v) const {
    Motion m(tree);
    EXPECT_TRUE(set_configuration(tree, q, m));
    set_rates(tree, v, m);
    return m;
  }
  std::vector<int> all_feet() const {
    std::vector<int> feet;
    for (int f = 0; f < count_of(model().feet); ++f) feet.push_back(f);
    return feet;
  }

  const AbsoluteTree tree{GetParam().model};
  std::mt19937 rng{3};
  static constexpr int kTrials = 10;
  static constexpr double kStep = 1e-5;
};

TEST_P(Identities, MassMatrixIsSymmetricPositiveDefinite) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const RandomState s = test_support::random_state(model(), rng);
    const Matrix M = mass_matrix(tree, at(s.q, s.v));
    EXPECT_LT((M - M.transpose()).cwiseAbs().maxCoeff(), 1e-14 * M.cwiseAbs().maxCoeff());
    EXPECT_EQ(Eigen::LLT<Matrix>(M).info(), Eigen::Success);
  }
}

/// Energies and momenta against sums over the bodies of finitely differenced positions.
TEST_P(Identities, EnergyAndMomentumMatchDifferencedPositions) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const RandomState s = test_support::random_state(model(), rng);
    const std::vector<plain::Frame> here = plain::frames(model(), tree, s.q);
    const std::vector<plain::Frame> later = plain::frames(model(), tree, s.q + kStep * s.v);
    const std::vector<plain::Frame> before = plain::frames(model(), tree, s.q - kStep * s.v);
    const Vec2 about(0.3, -0.2);
    double kinetic = plain::rotor_energy(model(), s.v), potential = 0.0, turning = 0.0;
    Vec2 momentum = Vec2::Zero(), moment_of_mass = Vec2::Zero();
    for (std::size_t b = 0; b < here.size(); ++b) {
      const model::PlanarBody& link = model().bodies[b];
      const Vec2 c = plain::point_of(here[b], link.com);
      const Vec2 velocity =
          (plain::point_of(later[b], link.com) - plain::point_of(before[b], link.com)) /
          (2.0 * kStep);
      const double turn = (later[b].angle - before[b].angle) / (2.0 * kStep);
      kinetic += 0.5 * (link.mass * velocity.squaredNorm() + link.inertia * turn * turn);
      potential += link.mass * model().gravity * c.y();
      momentum += link.mass * velocity;
      moment_of_mass += link.mass * c;
      turning +=
          link.mass * ((c.y() - about.y()) * velocity.x() - (c.x() - about.x()) * velocity.y());
      turning += link.inertia * turn;
    }
    const Motion m = at(s.q, s.v);
    const double tolerance = 1e-8 * (1.0 + kinetic);
    EXPECT_NEAR(kinetic_energy(tree, m, s.v), kinetic, tolerance);
    EXPECT_NEAR(0.5 * s.v.dot(mass_matrix(tree, m) * s.v), kinetic, tolerance);
    EXPECT_NEAR(potential_energy(tree, m), potential, 1e-12 * (1.0 + std::abs(potential)));
    EXPECT_LT((linear_momentum(tree, m) - momentum).norm(), tolerance);
    EXPECT_LT((centre_of_mass(tree, m) - moment_of_mass / model().total_mass()).norm(), 1e-13);
    EXPECT_NEAR(angular_momentum(tree, m, about), turning, tolerance);
  }
}

/// Angular momentum about two points differs by the moment of the linear momentum.
TEST_P(Identities, AngularMomentumShiftsByTheMomentOfMomentum) {
  const RandomState s = test_support::random_state(model(), rng);
  const Motion m = at(s.q, s.v);
  const Vec2 about(-0.7, 0.4), r = centre_of_mass(tree, m) - about, p = linear_momentum(tree, m);
  const double expected = angular_momentum(tree, m) + r.y() * p.x() - r.x() * p.y();
  EXPECT_NEAR(angular_momentum(tree, m, about), expected, 1e-12 * (1.0 + std::abs(expected)));
}

/// h(q, v) - h(q, 0) from Christoffel symbols of the differenced mass matrix, and with it that
/// dM/dt - 2 C is skew.
TEST_P(Identities, BiasIsTheChristoffelForceOfTheMassMatrix) {
  const int n = tree.n;
  for (int trial = 0; trial < kTrials; ++trial) {
    const RandomState s = test_support::random_state(model(), rng);
    std::vector<Matrix> dM;
    Vector dU(n);
    for (int k = 0; k < n; ++k) {
      const Motion plus = at(s.q + kStep * Vector::Unit(n, k), s.v),
                   minus = at(s.q - kStep * Vector::Unit(n, k), s.v);
      dM.push_back((mass_matrix(tree, plus) - mass_matrix(tree, minus)) / (2.0 * kStep));
      dU[k] = (potential_energy(tree, plus) - potential_energy(tree, minus)) / (2.0 * kStep);
    }
    Matrix C = Matrix::Zero(n, n), M_dot = Matrix::Zero(n, n);
    for (int k = 0; k < n; ++k) {
      M_dot += s.v[k] * dM[k];
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          C(i, j) += 0.5 * s.v[k] * (dM[k](i, j) + dM[j](i, k) - dM[i](j, k));
        }
      }
    }
    const Vector h = bias(tree, at(s.q, s.v)), gravity = bias(tree, at(s.q, Vector::Zero(n)));
    const double scale = 1.0 + h.cwiseAbs().maxCoeff();
    EXPECT_LT((gravity - dU).cwiseAbs().maxCoeff(), 1e-8 * scale);
    EXPECT_LT((h - gravity - C * s.v).cwiseAbs().maxCoeff(), 1e-7 * scale);
    // v^T (dM/dt - 2 C) v = 0 with the library's own C v.
    EXPECT_NEAR(s.v.dot(M_dot * s.v) - 2.0 * s.v.dot(h - gravity), 0.0,
                1e-7 * scale * (1.0 + s.v.norm()));
  }
}

TEST_P(Identities, ForwardAndInverseDynamicsAreInverse) {
  const std::vector<int> feet = all_feet();
  for (int trial = 0; trial < kTrials; ++trial) {
    const RandomState s = test_support::random_state(model(), rng);
    const Motion m = at(s.q, s.v);
    for (const std::vector<int>& stance : {std::vector<int>{}, feet}) {
      const Vector Q = 5.0 * s.a;
      const ContactSolution x = forward_dynamics(tree, m, Q, stance);
      ASSERT_TRUE(x.ok);
      const Vector back = inverse_dynamics(tree, m, x.motion, stance, x.force);
      EXPECT_LT((back - Q).cwiseAbs().maxCoeff(), 1e-9 * (1.0 + Q.cwiseAbs().maxCoeff()));
      for (int f : stance) {
        EXPECT_LT(point_acceleration(foot_point(tree, f), m, x.motion).norm(),
                  1e-9 * (1.0 + x.motion.norm()));
      }
    }
    const Vector force = Vector::Ones(2 * count_of(feet));
    const Vector Q = inverse_dynamics(tree, m, s.a, feet, force) +
                     foot_jacobian(tree, m, feet).transpose() * force;
    const ContactSolution free = forward_dynamics(tree, m, Q, {});
    ASSERT_TRUE(free.ok);
    EXPECT_LT((free.motion - s.a).cwiseAbs().maxCoeff(), 1e-9 * (1.0 + s.a.norm()));
  }
}

/// d(kinetic + potential)/dt along the motion equals the power of the generalised forces.
TEST_P(Identities, PowerBalances) {
  const auto energy = [&](const Vector& q, const Vector& v) {
    const Motion m = at(q, v);
    return kinetic_energy(tree, m, v) + potential_energy(tree, m);
  };
  for (int trial = 0; trial < kTrials; ++trial) {
    const RandomState s = test_support::random_state(model(), rng);
    const ContactSolution x = forward_dynamics(tree, at(s.q, s.v), s.a, {});
    ASSERT_TRUE(x.ok);
    const double h = 1e-6;
    const double rate =
        (energy(s.q + h * s.v, s.v + h * x.motion) - energy(s.q - h * s.v, s.v - h * x.motion)) /
        (2 * h);
    EXPECT_NEAR(rate, s.v.dot(s.a), 1e-7 * (1.0 + std::abs(energy(s.q, s.v)) + std::abs(rate)));
  }
}

/// Feet stop; the momentum gained is the feet's impulse, its moment too; what is lost is the energy
/// of the change of rate.
TEST_P(Identities, PlasticImpactKeepsMomentumAndLosesEnergy) {
  for (int f : all_feet()) {
    for (int trial = 0; trial < kTrials; ++trial) {
      const RandomState s = test_support::random_state(model(), rng);
      const Motion before = at(s.q, s.v);
      const ContactSolution x = plastic_impact(tree, before, s.v, {f});
      ASSERT_TRUE(x.ok);
      const Motion after = at(s.q, x.motion);
      const Vec2 impulse = x.force, foot = foot_position(tree, after, f);
      EXPECT_LT(foot_velocity(tree, after, f).norm(), 1e-11);
      EXPECT_LT((linear_momentum(tree, after) - linear_momentum(tree, before) - impulse).norm(),
                1e-11);
      EXPECT_NEAR(angular_momentum(tree, after, foot), angular_momentum(tree, before, foot), 1e-11);
      const double lost = kinetic_energy(tree, before, s.v) - kinetic_energy(tree, after, x.motion);
      const Vector change = s.v - x.motion;
      EXPECT_GT(lost, 0.0);
      EXPECT_NEAR(lost, 0.5 * change.dot(mass_matrix(tree, before) * change), 1e-10 * (1.0 + lost));
    }
  }
}

/// Loop residuals of position (by the independent kinematics), velocity and acceleration.
TEST_P(Identities, LoopsStayClosed) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const RandomState s = test_support::random_state(model(), rng);
    const Motion m = at(s.q, s.v);
    const std::vector<plain::Frame> frames = plain::frames(model(), tree, s.q);
    for (std::size_t l = 0; l < model().loops.size(); ++l) {
      const model::PlanarLoop& loop = model().loops[l];
      const Vec2 a = plain::point_of(frames[loop.body_a], loop.point_a);
      const Vec2 b = plain::point_of(frames[loop.body_b], loop.point_b);
      const PointSum gap{{1.0, tree.loops[l].a}, {-1.0, tree.loops[l].b}};
      EXPECT_LT((a - b).norm(), 1e-12);
      EXPECT_LT(point_position(gap, m).norm(), 1e-12);
      EXPECT_LT(point_velocity(gap, m).norm(), 1e-12);
      EXPECT_LT(point_acceleration(gap, m, s.a).norm(),
                1e-12 * (1.0 + s.a.norm() + s.v.squaredNorm()));
      const Vec2 anchor_a = frames[loop.body_a].position;
      const Vec2 u = frames[loop.body_b].position - anchor_a, w = a - anchor_a;
      EXPECT_GT(loop.branch * (u.y() * w.x() - u.x() * w.y()), 0.0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Models, Identities, ::testing::ValuesIn(test_support::sample_models()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace jaculus::dynamics
