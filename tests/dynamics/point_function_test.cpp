// Functions of a point (foot, centre of mass, difference of two points): derivatives against
// central differences.

#include <gtest/gtest.h>

#include <random>

#include "jaculus/dynamics/rigid_body.h"
#include "support/random_state.h"
#include "support/sample_models.h"

namespace jaculus::dynamics {
namespace {

struct Weights {
  Vec2 position, velocity;
};

/// phi and its gradient at w = (q, v), from a clean motion.
double value(const AbsoluteTree& tree, const PointSum& point, const Weights& weights,
             const Vector& w) {
  Motion motion(tree);
  EXPECT_TRUE(set_configuration(tree, w.head(tree.n), motion));
  set_rates(tree, w.tail(tree.n), motion);
  return weights.position.dot(point_position(point, motion)) +
         weights.velocity.dot(point_velocity(point, motion));
}

Vector gradient(const AbsoluteTree& tree, const PointSum& point, const Weights& weights,
                const Vector& w) {
  Motion motion(tree);
  PointScratch scratch(tree);
  EXPECT_TRUE(set_configuration(tree, w.head(tree.n), motion));
  set_rates(tree, w.tail(tree.n), motion);
  set_rate_sensitivity(tree, motion);
  Vector g = Vector::Zero(2 * tree.n);
  add_point_gradient(tree, motion, point, weights.position, weights.velocity, g, scratch);
  return g;
}

/// The Hessian, from scratch filled with NaN so that nothing stale can be read.
Matrix hessian(const AbsoluteTree& tree, const PointSum& point, const Weights& weights,
               const Vector& w) {
  Motion motion(tree);
  PointScratch scratch(tree);
  for (Vector* x : {&scratch.g_Y, &scratch.g_V, &scratch.chi_0, &scratch.chi_1, &scratch.dependent})
    x->setConstant(kNaN);
  for (Matrix* x : {&scratch.YY, &scratch.YV, &scratch.YY_G, &scratch.YV_G, &scratch.YV_X})
    x->setConstant(kNaN);
  EXPECT_TRUE(set_configuration(tree, w.head(tree.n), motion));
  set_rates(tree, w.tail(tree.n), motion);
  set_rate_sensitivity(tree, motion);
  Matrix H = Matrix::Zero(2 * tree.n, 2 * tree.n);
  add_point_hessian(tree, motion, point, weights.position, weights.velocity, H, scratch);
  return H;
}

void check(const AbsoluteTree& tree, const PointSum& point, const Weights& weights,
           const Vector& w) {
  const Vector g = gradient(tree, point, weights, w);
  const Matrix H = hessian(tree, point, weights, w);
  const double h = 1e-5, scale_g = 1.0 + g.cwiseAbs().maxCoeff(),
               scale_H = 1.0 + H.cwiseAbs().maxCoeff();
  for (int j = 0; j < w.size(); ++j) {
    Vector plus = w, minus = w;
    plus[j] += h;
    minus[j] -= h;
    const double slope =
        (value(tree, point, weights, plus) - value(tree, point, weights, minus)) / (2 * h);
    EXPECT_NEAR(g[j], slope, 1e-8 * scale_g) << "row " << j;
    const Vector column =
        (gradient(tree, point, weights, plus) - gradient(tree, point, weights, minus)) / (2 * h);
    EXPECT_LT((H.col(j) - column).cwiseAbs().maxCoeff(), 1e-8 * scale_H) << "column " << j;
  }
  EXPECT_LT((H - H.transpose()).cwiseAbs().maxCoeff(), 1e-12 * scale_H);
}

class PointFunction : public ::testing::TestWithParam<test_support::NamedModel> {};

TEST_P(PointFunction, DerivativesMatchCentralDifferences) {
  const model::PlanarModel& model = GetParam().model;
  const AbsoluteTree tree(model);
  std::vector<PointSum> points{centre_of_mass_point(tree)};
  for (int f = 0; f < count_of(model.feet); ++f) {
    points.push_back(foot_point(tree, f));
    PointSum relative = points.front();
    relative.push_back({-1.0, tree.feet[f]});
    points.push_back(relative);
  }
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int trial = 0; trial < 8; ++trial) {
    const test_support::RandomState s = test_support::random_state(model, rng);
    Vector w(2 * tree.n);
    w << s.q, s.v;
    Weights weights{Vec2(unit(rng), unit(rng)), Vec2(unit(rng), unit(rng))};
    if (trial == 6) weights.velocity.setZero();
    if (trial == 7) weights.position.setZero();
    for (const PointSum& point : points) check(tree, point, weights, w);
  }
}

/// Results are added to what the caller holds, not written over it.
TEST_P(PointFunction, AddsToTheCallersSums) {
  const AbsoluteTree tree(GetParam().model);
  std::mt19937 rng(5);
  const test_support::RandomState s = test_support::random_state(GetParam().model, rng);
  Motion motion(tree);
  PointScratch scratch(tree);
  ASSERT_TRUE(set_configuration(tree, s.q, motion));
  set_rates(tree, s.v, motion);
  set_rate_sensitivity(tree, motion);
  const PointSum point = centre_of_mass_point(tree);
  const Vec2 w_p(0.3, -0.8), w_v(-0.2, 0.7);
  const int size = 2 * tree.n;
  Vector once = Vector::Zero(size), twice = Vector::Ones(size);
  Matrix H_once = Matrix::Zero(size, size), H_twice = Matrix::Ones(size, size);
  add_point_gradient(tree, motion, point, w_p, w_v, once, scratch);
  add_point_hessian(tree, motion, point, w_p, w_v, H_once, scratch);
  for (int i = 0; i < 2; ++i) {
    add_point_gradient(tree, motion, point, w_p, w_v, twice, scratch);
    add_point_hessian(tree, motion, point, w_p, w_v, H_twice, scratch);
  }
  EXPECT_LT((twice - Vector::Ones(size) - 2.0 * once).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT((H_twice - Matrix::Ones(size, size) - 2.0 * H_once).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_GT(once.cwiseAbs().maxCoeff(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Models, PointFunction, ::testing::ValuesIn(test_support::sample_models()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace jaculus::dynamics
