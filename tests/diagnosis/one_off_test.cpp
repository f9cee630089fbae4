// What happened to one trial only, and trials that merely end sooner.

#include "diagnosis/noise/one_off.h"

#include <gtest/gtest.h>

#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

std::vector<OneOff> one_offs(const Problem& problem) {
  return one_off_disturbances(problem, estimate_noise(problem, Vector::Zero(4)));
}

/// All trials leave the model from 0.25 s on, as by an effect.
test::ToyData leaving() {
  test::ToyData data;
  data.segments = 6;
  data.extra = [](int, double t) { return t > 0.25 ? 0.2 * (t - 0.25) : 0.0; };
  return data;
}

TEST(OneOff, IsTheTrialThatLeavesTheOthers) {
  test::ToyData data = leaving();
  data.pushed = 2;
  const auto found = one_offs(*test::toy_problem(test::toy_truth(0.0, 0.0), data));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.front().segment, 2);
  EXPECT_NEAR(found.front().onset, 0.3, 0.06);
}

TEST(OneOff, IsNoTrialThatEndsSoonerThanOthers) {
  // A trial without rows once counted as one at zero, far from where the others are.
  for (const int cut : {1, 2, 5}) {
    auto problem = test::toy_problem(test::toy_truth(0.0, 0.0), leaving());
    std::vector<SegmentTail> tails;
    for (int s = 0; s < cut; ++s) tails.push_back({0, s, 0.3});
    problem->observations = without_tails(std::move(problem->observations), tails);
    EXPECT_TRUE(one_offs(*problem).empty()) << cut;
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
