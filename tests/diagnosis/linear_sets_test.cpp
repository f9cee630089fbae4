// Sets by linear algebra, on a problem that is linear, so that it doesn't matter about which fit.

#include "diagnosis/selection/linear_sets.h"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/posterior.h"
#include "toy.h"

namespace jaculus::test {
namespace {

using diagnosis::Fit;
using diagnosis::LinearSet;
using diagnosis::Probe;
using diagnosis::Screening;

const LinearSet* find(const std::vector<LinearSet>& sets, const std::vector<int>& members) {
  for (const LinearSet& set : sets)
    if (set.members == members) return &set;
  return nullptr;
}

/// A problem whose two candidates act, fitted without them and with the first.
struct TwoFits {
  std::shared_ptr<diagnosis::Problem> problem = toy_problem(toy_truth(0.2, 0.1));
  diagnosis::Comparison comparison =
      diagnosis::comparison_about(*problem, diagnosis::estimate_noise(*problem, Vector::Zero(4)));
  Fit none = diagnosis::fit_model(*problem, comparison.whitening, {}, {Vector::Zero(4)});
  Fit first = diagnosis::fit_model(*problem, comparison.whitening, {0},
                                   {Vector(0.05 * Vector::Unit(4, 0))});
};

TEST(LinearSets, AreTheSameAboutNoneAndAboutAFit) {
  const TwoFits fits;
  const auto& [problem, comparison, none, first] = fits;
  const diagnosis::Whitening& whitening = comparison.whitening;
  ASSERT_TRUE(none.valid && first.valid);

  const std::vector<std::vector<int>> sets = {{0}, {1}, {0, 1}};
  const auto about_none =
      linear_sets(*problem, whitening, none, {}, screen(*problem, whitening, none), sets);
  const auto about_first =
      linear_sets(*problem, whitening, first, {0}, screen(*problem, whitening, first), sets);
  EXPECT_EQ(about_none.front().members, (std::vector<int>{0, 1}));
  for (const std::vector<int>& members : sets) {
    const LinearSet *a = find(about_none, members), *b = find(about_first, members);
    ASSERT_TRUE(a != nullptr && b != nullptr);
    EXPECT_NEAR(a->log_evidence, b->log_evidence, 1e-3 * std::abs(a->log_evidence));
    EXPECT_LT((a->mean - b->mean).norm(), 1e-3 * a->mean.norm());
  }
  const LinearSet* both = find(about_first, {0, 1});
  EXPECT_NEAR(0.1 * both->mean[0], 0.2, 0.01);
  EXPECT_NEAR(0.1 * both->mean[1], 0.1, 0.01);
}

TEST(Screen, TakesOneStepOfWhatWasLinearBefore) {
  const TwoFits fits;
  const auto& [problem, comparison, none, first] = fits;
  const diagnosis::Whitening& whitening = comparison.whitening;
  const std::vector<Probe> before = screen(*problem, whitening, none);
  ASSERT_TRUE(before[1].linear);

  const Probe two = screen(*problem, whitening, first)[1],
              one = screen(*problem, whitening, first, Screening::steps, &before)[1];
  EXPECT_EQ(2 * one.predictions, two.predictions);
  EXPECT_TRUE(one.valid && one.linear);
  EXPECT_NEAR(one.score, two.score, 1e-2 * two.score);
  EXPECT_NEAR(one.estimate[0], two.estimate[0], 1e-2 * two.estimate[0]);

  // One that was not is probed at both.
  std::vector<Probe> bent = before;
  bent[1].linear = false;
  EXPECT_EQ(screen(*problem, whitening, first, Screening::steps, &bent)[1].predictions,
            two.predictions);
}

TEST(LinearSets, LeaveOutWhatWouldHaveToWorkTheWrongWay) {
  // The data bend the other way than `first`, which has one side, can bend them.
  const auto problem = toy_problem(toy_truth(-0.2, 0.0));
  const diagnosis::Comparison comparison =
      diagnosis::comparison_about(*problem, diagnosis::estimate_noise(*problem, Vector::Zero(4)));
  const Fit none = diagnosis::fit_model(*problem, comparison.whitening, {}, {Vector::Zero(4)});
  const auto sets = linear_sets(*problem, comparison.whitening, none, {},
                                screen(*problem, comparison.whitening, none), {{0}, {1}});
  EXPECT_EQ(find(sets, {0}), nullptr);
  EXPECT_NE(find(sets, {1}), nullptr);
}

TEST(LogPrior, SharesASizesProbabilityAmongItsSets) {
  const diagnosis::Settings settings;
  EXPECT_NEAR(std::exp(diagnosis::log_prior(2, 10, settings)) * 45.0, settings.prior_pair, 1e-12);
  EXPECT_NEAR(std::exp(diagnosis::log_prior(3, 10, settings)) * 120.0, settings.prior_triple,
              1e-12);
  // Each effect more costs what the third did.
  const double step = settings.prior_triple / settings.prior_pair;
  EXPECT_NEAR(std::exp(diagnosis::log_prior(5, 10, settings)) * 252.0,
              settings.prior_triple * step * step, 1e-12);
}

}  // namespace
}  // namespace jaculus::test
