// Equations of motion against central differences and independent identities.

#include "jaculus/components/equations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/sample_models.h"

namespace jaculus::components {
namespace {

struct Sample {
  Vector q, v, u;
};

Sample random_sample(const model::PlanarModel& model, int inputs, std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Sample s{Vector(model.size()), Vector(model.size()), Vector(inputs)};
  for (int i = 0; i < model.size(); ++i) {
    const Bounds range = model.coordinates[i].range;
    const bool bounded = std::isfinite(range.lower) && std::isfinite(range.upper);
    s.q[i] = bounded
                 ? 0.5 * (range.lower + range.upper) + 0.4 * unit(rng) * (range.upper - range.lower)
                 : unit(rng);
    s.v[i] = 3.0 * unit(rng);
  }
  for (int i = 0; i < inputs; ++i) s.u[i] = 2.0 * unit(rng);
  return s;
}

/// (a, force) at (q, v, u) stacked in w.
Vector solve(const Equations& eq, const Vector& w, EquationsPoint& p) {
  const int n = eq.size();
  EXPECT_TRUE(eq.evaluate(w.head(n), w.segment(n, n), w.tail(eq.inputs()), p));
  Vector z(n + p.force.size());
  z << p.a, p.force;
  return z;
}

/// (jump of the rates, impulses) at (q, v), inputs ignored.
Vector jump(const Equations& eq, const Vector& w, EquationsPoint& p) {
  const int n = eq.size();
  EXPECT_TRUE(eq.evaluate_impact(w.head(n), w.segment(n, n), p));
  Vector z(n + p.force.size());
  z << p.a, p.force;
  return z;
}

using Solution = Vector (*)(const Equations&, const Vector&, EquationsPoint&);

class EquationsDerivatives : public ::testing::TestWithParam<test_support::NamedModel> {};

/// Central differences of the solution and of its gradient contracted with mu, column by column.
void check_derivatives(const Equations& eq, const Vector& w, Solution solution, EquationsPoint& p,
                       EquationsPoint& other) {
  const Vector z = solution(eq, w, p);
  p.Z.setConstant(kNaN);
  eq.differentiate(p);
  const Vector mu = Vector::Random(z.size());
  Matrix H = Matrix::Zero(w.size(), w.size());
  eq.add_hessian(mu, p, H);
  const double h = 1e-6, scale_Z = 1.0 + p.Z.cwiseAbs().maxCoeff(),
               scale_H = 1.0 + H.cwiseAbs().maxCoeff();
  for (int j = 0; j < w.size(); ++j) {
    Vector z_at[2], gradient[2];
    for (int side = 0; side < 2; ++side) {
      Vector moved = w;
      moved[j] += side == 0 ? -h : h;
      z_at[side] = solution(eq, moved, other);
      eq.differentiate(other);
      gradient[side] = other.Z.transpose() * mu;
    }
    EXPECT_LT((p.Z.col(j) - (z_at[1] - z_at[0]) / (2 * h)).cwiseAbs().maxCoeff(), 1e-7 * scale_Z)
        << "column " << j;
    EXPECT_LT((H.col(j) - (gradient[1] - gradient[0]) / (2 * h)).cwiseAbs().maxCoeff(),
              1e-7 * scale_H)
        << "column " << j;
  }
  EXPECT_LT((H - H.transpose()).cwiseAbs().maxCoeff(), 1e-10 * scale_H);
}

TEST_P(EquationsDerivatives, FirstAndSecondMatchCentralDifferences) {
  const model::PlanarModel& model = GetParam().model;
  // ample smoothing: differences need third derivatives of order one
  const Equations eq(model, 0.5);
  std::mt19937 rng(7);
  for (int trial = 0; trial < 6; ++trial) {
    std::vector<int> feet;
    for (int f = 0; f < count_of(model.feet); ++f)
      if (trial % 3 == 0 || (trial % 3 == 1 && f > 0)) feet.push_back(f);
    EquationsPoint p(eq, feet), other(eq, feet);
    const Sample s = random_sample(model, eq.inputs(), rng);
    Vector w(2 * eq.size() + eq.inputs());
    w << s.q, s.v, s.u;
    check_derivatives(eq, w, solve, p, other);
    check_derivatives(eq, w, jump, p, other);
  }
}

TEST(EquationsImpact, StopsTheFeetAndLosesEnergy) {
  const model::PlanarModel model = test_support::sample_models()[2].model;
  const Equations eq(model);
  std::mt19937 rng(3);
  EquationsPoint p(eq, {0, 1});
  const Sample s = random_sample(model, eq.inputs(), rng);
  ASSERT_TRUE(eq.evaluate_impact(s.q, s.v, p));
  const Matrix M = p.mass;
  const Vector after = s.v + p.a;
  EXPECT_LT((p.J_f * p.motion.G * after).norm(), 1e-12);
  EXPECT_LT(after.dot(M * after), s.v.dot(M * s.v));
  EXPECT_NEAR(after.dot(M * p.a), 0.0, 1e-10);  // the impulses do no work on the motion after
}

/// The same robots with friction at every motor.
TEST_P(EquationsDerivatives, HoldWithFrictionOfTheMotors) {
  model::PlanarModel model = GetParam().model;
  if (model.motors.empty()) GTEST_SKIP() << "no motor";
  for (model::PlanarMotor& motor : model.motors) {
    motor.viscous_friction = 0.05;
    motor.dry_friction = 0.3;
  }
  const Equations eq(model, 0.5);
  std::mt19937 rng(11);
  std::vector<int> feet;
  for (int f = 0; f < count_of(model.feet); ++f) feet.push_back(f);
  EquationsPoint p(eq, feet), other(eq, feet);
  for (int trial = 0; trial < 3; ++trial) {
    const Sample s = random_sample(model, eq.inputs(), rng);
    Vector w(2 * eq.size() + eq.inputs());
    w << s.q, s.v, s.u;
    check_derivatives(eq, w, solve, p, other);
    check_derivatives(eq, w, jump, p, other);
  }
}

/// Viscous friction is a torque beside the motor's: the same motion follows from a motor that makes
/// both. What is dry the motor makes up for, so that it changes nothing.
TEST_P(EquationsDerivatives, ViscousFrictionIsATorqueBesideTheMotorsAndDryOneIsMadeUpFor) {
  const model::PlanarModel& smooth = GetParam().model;
  if (smooth.motors.empty()) GTEST_SKIP() << "no motor";
  model::PlanarModel rubbing = smooth;
  for (model::PlanarMotor& motor : rubbing.motors) {
    motor.viscous_friction = 0.05;
    motor.dry_friction = 0.3;
  }
  const Equations with(rubbing), without(smooth);
  std::mt19937 rng(5);
  EquationsPoint p(with, {}), other(without, {});
  const Sample s = random_sample(smooth, with.inputs(), rng);
  Vector u = s.u;
  for (int m = 0; m < with.inputs(); ++m) {
    const double rate = smooth.joint_map.row(smooth.motors[m].body).dot(s.v);
    u[m] -= 0.05 * rate;
  }
  ASSERT_TRUE(with.evaluate(s.q, s.v, s.u, p));
  ASSERT_TRUE(without.evaluate(s.q, s.v, u, other));
  EXPECT_LT((p.a - other.a).norm(), 1e-12 * (1.0 + p.a.norm()));
}

INSTANTIATE_TEST_SUITE_P(Models, EquationsDerivatives,
                         ::testing::ValuesIn(test_support::sample_models()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace jaculus::components
