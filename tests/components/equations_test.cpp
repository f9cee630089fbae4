// Equations of motion against central differences and independent identities.

#include "jaculus/components/equations.h"

#include <gtest/gtest.h>

#include <random>

#include "support/sample_models.h"

namespace jaculus {
namespace {

struct Sample {
  Vector q, v, u;
};

Sample random_sample(const PlanarModel& model, int inputs, std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Sample s{Vector(model.size()), Vector(model.size()), Vector(inputs)};
  for (int i = 0; i < model.size(); ++i) {
    const Bounds range = model.coordinates[static_cast<size_t>(i)].range;
    const bool bounded = std::isfinite(range.lower) && std::isfinite(range.upper);
    s.q[i] = bounded ? 0.5 * (range.lower + range.upper) + 0.4 * unit(rng) * (range.upper - range.lower) : unit(rng);
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

class EquationsDerivatives : public ::testing::TestWithParam<test_support::NamedModel> {};

TEST_P(EquationsDerivatives, FirstAndSecondMatchCentralDifferences) {
  const PlanarModel& model = GetParam().model;
  const Equations eq(model, 0.5);  // ample smoothing: differences need third derivatives of order one
  std::mt19937 rng(7);
  for (int trial = 0; trial < 6; ++trial) {
    std::vector<int> feet;
    for (int f = 0; f < static_cast<int>(model.feet.size()); ++f)
      if (trial % 3 == 0 || (trial % 3 == 1 && f > 0)) feet.push_back(f);
    EquationsPoint p(eq, feet), other(eq, feet);
    const Sample s = random_sample(model, eq.inputs(), rng);
    const int n = eq.size(), w_size = 2 * n + eq.inputs();
    Vector w(w_size);
    w << s.q, s.v, s.u;
    const Vector z = solve(eq, w, p);
    p.Z.setConstant(kNaN);
    eq.differentiate(p);
    Vector mu = Vector::Random(z.size());
    Matrix H = Matrix::Zero(w_size, w_size);
    eq.add_hessian(mu, p, H);
    const double h = 1e-5;
    const double scale_Z = 1.0 + p.Z.cwiseAbs().maxCoeff(), scale_H = 1.0 + H.cwiseAbs().maxCoeff();
    for (int j = 0; j < w_size; ++j) {
      Vector plus = w, minus = w;
      plus[j] += h;
      minus[j] -= h;
      const Vector zp = solve(eq, plus, other);
      eq.differentiate(other);
      const Vector gp = other.Z.transpose() * mu;
      const Vector zm = solve(eq, minus, other);
      eq.differentiate(other);
      const Vector gm = other.Z.transpose() * mu;
      EXPECT_LT((p.Z.col(j) - (zp - zm) / (2 * h)).cwiseAbs().maxCoeff(), 1e-7 * scale_Z) << "column " << j;
      EXPECT_LT((H.col(j) - (gp - gm) / (2 * h)).cwiseAbs().maxCoeff(), 1e-7 * scale_H) << "column " << j;
    }
    EXPECT_LT((H - H.transpose()).cwiseAbs().maxCoeff(), 1e-10 * scale_H);
  }
}

INSTANTIATE_TEST_SUITE_P(Models, EquationsDerivatives, ::testing::ValuesIn(test_support::sample_models()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace jaculus
