#include "diagnosis/held_out_rules.h"

#include <gtest/gtest.h>

#include "diagnosis/toy.h"
#include "jaculus/diagnosis/evidence_space.h"

namespace jaculus::test {
namespace {

/// None, both singles and the pair, fitted and weighed.
struct Fitted {
  explicit Fitted(const Vector& truth) : problem(toy_problem(truth)), about(linearise(*problem, Vector::Zero(4))) {
    const EvidenceSpace space = evidence_space(*problem, about);
    selection.probes.resize(4);
    for (const std::vector<int>& members : {std::vector<int>{}, {0}, {1}, {0, 1}}) {
      ModelFit model;
      model.candidates = members;
      model.fit = fit_model(*problem, space, members, {Vector::Zero(4), Vector::Constant(4, 0.1)});
      model.log_prior = log_prior(members.size(), 4);
      selection.models.push_back(model);
    }
    weigh(selection);
  }

  std::shared_ptr<DiagnosisProblem> problem;
  Linearisation about;
  Selection selection;
};

TEST(HeldOutRules, AskForAnEffectThatTheFormOfAnotherMightHide) {
  Fitted toy(toy_truth(0.5, 0.01));  // the second explains half a percent of what the first does
  EXPECT_LT(toy.selection.involved[1], 0.01);
  HeldOutGaps gaps(*toy.problem, toy.about, find_model(toy.selection, {})->fit);
  EXPECT_GT(gaps.of(*find_model(toy.selection, {0})).after, 3.0);
  heed_held_out(gaps, toy.selection);
  EXPECT_GT(toy.selection.involved[1], 0.99);
  EXPECT_EQ(toy.selection.models.front().candidates, (std::vector<int>{0, 1}));
}

TEST(HeldOutRules, LeaveASetAloneWhereOneEffectIsEnough) {
  Fitted toy(toy_truth(0.5, 0.0));
  HeldOutGaps gaps(*toy.problem, toy.about, find_model(toy.selection, {})->fit);
  const std::vector<double> before = toy.selection.involved;
  heed_held_out(gaps, toy.selection);
  EXPECT_EQ(toy.selection.involved, before);
  EXPECT_GT(before[0], 0.99);
}

TEST(HeldOutRules, PruneMembersThatPredictNothing) {
  Fitted toy(toy_truth(0.5, 0.0));
  HeldOutGaps gaps(*toy.problem, toy.about, find_model(toy.selection, {})->fit);
  EXPECT_EQ(prune(toy.selection, gaps, find_model(toy.selection, {0, 1}))->candidates, std::vector<int>{0});
  Fitted both(toy_truth(0.5, 0.2));
  HeldOutGaps of_both(*both.problem, both.about, find_model(both.selection, {})->fit);
  EXPECT_EQ(prune(both.selection, of_both, find_model(both.selection, {0, 1}))->candidates, (std::vector<int>{0, 1}));
}

TEST(HeldOutRules, JudgeNothingByGapsThatAreNotThere) {
  Fitted toy(toy_truth(0.5, 0.01));
  HeldOutGaps gaps(*toy.problem, toy.about, find_model(toy.selection, {})->fit);
  toy.problem->forward = [](int, int, const Vector&) { return Prediction{}; };  // no simulation succeeds any more
  ASSERT_FALSE(gaps.of(*find_model(toy.selection, {0, 1})).valid);
  EXPECT_FALSE(heed_held_out(gaps, toy.selection));
  EXPECT_EQ(prune(toy.selection, gaps, find_model(toy.selection, {0, 1}))->candidates, (std::vector<int>{0, 1}));
}

TEST(HeldOutRules, FindSomethingUnknownInASetThatTheyAskFor) {
  Fitted toy(toy_truth(0.5, 0.01));
  HeldOutGaps gaps(*toy.problem, toy.about, find_model(toy.selection, {})->fit);
  for (ModelFit& m : toy.selection.models) m.structure = m.candidates.size() == 2 ? 1e7 : -1e7;
  heed_held_out(gaps, toy.selection);
  EXPECT_GT(toy.selection.unexplained, 0.99);
}

TEST(HeldOutRules, WithdrawEffectsThatPredictNothing) {
  Diagnosis small;
  small.verdict = "effect";
  small.effects.push_back({"a", "", 0.9, {}, {}});
  small.gap = {true, "trials", 4, 1.2, 1.17, 100.0, {}, {}, {}};  // 2.5 % of a small gap
  Diagnosis large = small, good = small, left = small;
  large.gap.before = 4.0;
  large.gap.after = 3.9;
  good.gap.after = 1.0;
  left.gap.before = 20.0;
  left.gap.after = 3.5;
  left.gap.shrink = 1.0 - 2.5 / 19.0;
  for (Diagnosis* d : {&small, &large, &good, &left}) demand_prediction(*d);
  EXPECT_EQ(small.verdict, "none");
  EXPECT_EQ(large.verdict, "unexplained");
  EXPECT_EQ(good.verdict, "effect");
  EXPECT_EQ(left.verdict, "unexplained");
  EXPECT_TRUE(small.effects.empty() && large.effects.empty() && left.effects.empty());
  EXPECT_EQ(good.effects.size(), 1u);
}

}  // namespace
}  // namespace jaculus::test
