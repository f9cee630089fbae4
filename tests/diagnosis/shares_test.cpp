// Shares of the held-out gap's energy on a problem whose effects are known.

#include "diagnosis/validation/shares.h"

#include <gtest/gtest.h>

#include "diagnosis/toy.h"
#include "diagnosis/validation/fold_interval.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/diagnosis_json.h"
#include "support/input_error.h"

namespace jaculus::diagnosis {
namespace {

using test::toy_problem;
using test::toy_truth;

/// A model of some candidates, fitted, and what judges it.
struct FittedSet {
  FittedSet(const Vector& truth, const std::vector<int>& members)
      : problem(toy_problem(truth)),
        comparison(comparison_about(*problem, estimate_noise(*problem, Vector::Zero(4)))),
        none(fit_model(*problem, comparison.whitening, {}, {Vector::Zero(4)})),
        gaps(*problem, comparison, posterior, none, none) {
    model.candidates = members;
    Vector start = Vector::Zero(4);  // what is not freed stays
    for (const int i : members) start[i] = 0.1;
    model.fit = fit_model(*problem, comparison.whitening, members, {start});
  }
  [[nodiscard]] double explained(const HeldOut& gap) const {
    return 1.0 - (gap.after * gap.after - 1.0) / (gap.before * gap.before - 1.0);
  }
  [[nodiscard]] std::vector<std::optional<EffectShare>> shares() { return shares_of(gaps, model); }

  std::shared_ptr<Problem> problem;
  Comparison comparison;
  Fit none;
  Posterior posterior;
  HeldOutGaps gaps;
  ModelFit model;
};

TEST(Shares, OfOneEffectAreAllThreeWhatItExplains) {
  FittedSet toy(toy_truth(0.0, 0.05), {1});
  const auto shares = toy.shares();
  ASSERT_TRUE(shares.at(0));
  const double explained = toy.explained(toy.gaps.of(toy.model));
  EXPECT_GT(explained, 0.95);
  EXPECT_DOUBLE_EQ(shares[0]->alone, explained);
  EXPECT_DOUBLE_EQ(shares[0]->last, explained);
  EXPECT_DOUBLE_EQ(shares[0]->shapley, explained);
  EXPECT_TRUE(shares[0]->ci95.contains(explained));
}

TEST(Shares, OfShapleySumToWhatTheSetExplains) {
  for (const std::vector<int>& members : {std::vector<int>{0, 1}, {0, 1, 3}}) {
    FittedSet toy(toy_truth(0.2, 0.05), members);
    double sum = 0.0;
    for (const auto& share : toy.shares()) {
      ASSERT_TRUE(share);
      sum += share->shapley;
    }
    EXPECT_NEAR(sum, toy.explained(toy.gaps.of(toy.model)), 1e-12);
  }
}

TEST(Shares, OfWhatDoesNothingAreNought) {
  FittedSet toy(toy_truth(0.0, 0.05), {1, 3});  // second, and one that nothing shows
  const auto shares = toy.shares();
  ASSERT_TRUE(shares.at(0) && shares.at(1));
  EXPECT_GT(shares[0]->last, 0.95);
  EXPECT_NEAR(shares[1]->alone, 0.0, 0.01);
  EXPECT_NEAR(shares[1]->last, 0.0, 0.01);
  EXPECT_NEAR(shares[1]->shapley, 0.0, 0.01);
}

TEST(Shares, OfTwinsAreHalvedAndNeitherIsMissed) {
  FittedSet toy(toy_truth(0.05, 0.0), {0, 2});  // either makes the same
  const auto shares = toy.shares();
  ASSERT_TRUE(shares.at(0) && shares.at(1));
  for (const auto& share : shares) {
    EXPECT_GT(share->alone, 0.95);
    EXPECT_NEAR(share->last, 0.0, 0.02);
    EXPECT_NEAR(share->shapley, 0.5, 0.03);
  }
}

TEST(Shares, AreNotStatedOfAGapWithinNoise) {
  FittedSet toy(toy_truth(0.0, 0.0), {1});
  EXPECT_FALSE(toy.shares().at(0));
}

TEST(Shares, StandInTheAnswer) {
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.05)));
  ASSERT_EQ(d.effects.size(), 1u);
  ASSERT_TRUE(d.effects[0].share);
  EXPECT_GT(d.effects[0].share->alone, 0.95);
  EXPECT_TRUE(test::holds(diagnosis_json(d), "\"shapley\": "));
  EXPECT_TRUE(test::holds(diagnosis_text(d), "of the held-out gap's energy"));
}

TEST(Shares, OfRivalsAreThoseAlone) {
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.05, 0.0)));
  ASSERT_EQ(d.verdict, Verdict::ambiguous) << diagnosis_text(d);
  ASSERT_EQ(d.effects.size(), 2u);
  for (const FoundEffect& effect : d.effects) {
    ASSERT_TRUE(effect.share) << effect.name;
    EXPECT_GT(effect.share->alone, 0.9) << effect.name;
  }
  EXPECT_TRUE(std::isnan(d.effects[1].share->last));
}

TEST(FoldInterval, IsStudentsAboutTheValue) {
  const Bounds ci = fold_interval({0.4, 0.6, kNaN}, 0.55);  // t of one degree: 12.706
  EXPECT_NEAR(ci.upper - 0.55, 12.7062 * 0.1, 1e-3);
  EXPECT_NEAR(0.55 - ci.lower, 12.7062 * 0.1, 1e-3);
  EXPECT_TRUE(std::isnan(fold_interval({0.4, kNaN}, 0.4).lower));
}

}  // namespace
}  // namespace jaculus::diagnosis
