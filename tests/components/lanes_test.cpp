// Four points in lanes are the four points one by one, bit for bit: values, first and second
// derivatives.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "jaculus/components/equations.h"
#include "support/sample_models.h"

namespace jaculus::components {
namespace {

/// What is random of a point.
struct State {
  Vector q, v, u, mu;
};

State random_state(const Equations& equations, int multipliers, std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto fill = [&](int size, double scale) {
    Vector x(size);
    for (double& value : x) value = scale * unit(rng);
    return x;
  };
  State state{fill(equations.size(), 0.4), fill(equations.size(), 3.0),
              fill(equations.inputs(), 2.0), fill(multipliers, 1.0)};
  for (int i = 0; i < equations.size(); ++i) {
    const Bounds range = equations.model().coordinates[i].range;
    if (std::isfinite(range.lower) && std::isfinite(range.upper))
      state.q[i] = 0.5 * (range.lower + range.upper) + state.q[i] * (range.upper - range.lower);
  }
  return state;
}

VectorOf<Lanes> in_lanes(const std::array<State, kLanes>& states, Vector State::*member) {
  VectorOf<Lanes> packed((states[0].*member).size());
  for (int i = 0; i < count_of(packed); ++i)
    for (int k = 0; k < kLanes; ++k) set_lane(packed[i], k, (states[k].*member)[i]);
  return packed;
}

template <class Packed, class Plain>
void expect_same(const Packed& lanes, const Plain& one, int k, const char* what) {
  ASSERT_EQ(lanes.size(), one.size()) << what;
  for (int i = 0; i < count_of(one); ++i)
    EXPECT_EQ(lane(lanes.data()[i], k), one.data()[i]) << what << ", element " << i;
}

class InLanes : public testing::TestWithParam<test_support::NamedModel> {};

TEST_P(InLanes, PointsHaveTheBitsOfOneByOne) {
  const Equations equations(GetParam().model);
  std::vector<int> feet(equations.tree().feet.empty() ? 0 : 1, 0);
  EquationsPoint point(equations, feet);
  EquationsPointOf<Lanes> points(equations, feet);
  const int s = count_of(point.Z) / count_of(point.Z.col(0)), z = count_of(point.Z.col(0));

  std::mt19937 rng(3);
  std::array<State, kLanes> states;
  for (State& state : states) state = random_state(equations, z, rng);
  const VectorOf<Lanes> q = in_lanes(states, &State::q), v = in_lanes(states, &State::v),
                        u = in_lanes(states, &State::u), mu = in_lanes(states, &State::mu);
  ASSERT_TRUE(equations.evaluate(q, v, u, points));
  equations.differentiate(points);
  MatrixOf<Lanes> curvature = MatrixOf<Lanes>::Constant(s, s, 0.0);
  equations.add_hessian(mu, points, curvature);

  for (int k = 0; k < kLanes; ++k) {
    ASSERT_TRUE(equations.evaluate(states[k].q, states[k].v, states[k].u, point));
    equations.differentiate(point);
    Matrix hessian = Matrix::Zero(s, s);
    equations.add_hessian(states[k].mu, point, hessian);
    expect_same(points.a, point.a, k, "accelerations");
    expect_same(points.force, point.force, k, "forces");
    expect_same(points.Z, point.Z, k, "first derivatives");
    expect_same(curvature, hessian, k, "second derivatives");
  }
}

INSTANTIATE_TEST_SUITE_P(Models, InLanes, testing::ValuesIn(test_support::sample_models()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace jaculus::components
