#include "diagnosis/validation/acceptance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/toy.h"
#include "diagnosis/verdict/proposal.h"

namespace jaculus::diagnosis {
namespace {

using test::toy_problem;
using test::toy_truth;

/// None, both singles and the pair, fitted.
struct Fitted {
  explicit Fitted(const Vector& truth)
      : problem(toy_problem(truth)),
        comparison(comparison_about(*problem, estimate_noise(*problem, Vector::Zero(4)))) {
    search.probes.resize(4);
    search.indistinguishable.resize(4);
    for (const std::vector<int>& members : {std::vector<int>{}, {0}, {1}, {0, 1}}) {
      ModelFit model;
      model.candidates = members;
      model.fit = fit_model(*problem, comparison.whitening, members,
                            {Vector::Zero(4), Vector::Constant(4, 0.1)});
      model.log_prior = log_prior(members.size(), 4, problem->settings);
      search.models.push_back(model);
    }
  }
  [[nodiscard]] HeldOutGaps gaps() const {
    return {*problem, comparison, search.models.front().fit};
  }

  std::shared_ptr<Problem> problem;
  Comparison comparison;
  SearchResult search;
};

TEST(Acceptance, AsksForAnEffectThatTheFormOfAnotherMightHide) {
  const Fitted toy(
      toy_truth(0.5, 0.01));  // the second explains half a percent of what the first does
  EXPECT_LT(posterior_of(toy.search, {}).inclusion[1], 0.01);
  HeldOutGaps gaps = toy.gaps();
  EXPECT_GT(gaps.of(toy.search.models[1]).after, 3.0);
  const AcceptedPosterior accepted = accepted_posterior(toy.search, gaps, {});
  EXPECT_TRUE(accepted.without_form);
  EXPECT_GT(accepted.posterior.inclusion[1], 0.99);
  EXPECT_EQ(accepted.posterior.models.front().candidates, (std::vector<int>{0, 1}));
}

TEST(Acceptance, LeavesAPosteriorAloneWhereOneEffectIsEnough) {
  const Fitted toy(toy_truth(0.5, 0.0));
  HeldOutGaps gaps = toy.gaps();
  const AcceptedPosterior accepted = accepted_posterior(toy.search, gaps, {});
  EXPECT_FALSE(accepted.without_form);
  EXPECT_EQ(accepted.posterior.inclusion, posterior_of(toy.search, {}).inclusion);
  EXPECT_GT(accepted.posterior.inclusion[0], 0.99);
}

TEST(Acceptance, LeavesOutMembersThatPredictNothing) {
  const Fitted toy(toy_truth(0.5, 0.0)), both(toy_truth(0.5, 0.2));
  for (const auto& [fitted, kept] :
       {std::pair(&toy, std::vector<int>{0}), std::pair(&both, std::vector<int>{0, 1})}) {
    HeldOutGaps gaps = fitted->gaps();
    const Posterior posterior = posterior_of(fitted->search, {});
    const ModelFit* pair = posterior.find({0, 1});
    EXPECT_EQ(without_idle_members(posterior, gaps, pair, {})->candidates, kept);
  }
}

TEST(Acceptance, JudgesNothingByGapsThatAreNotThere) {
  Fitted toy(toy_truth(0.5, 0.01));
  HeldOutGaps gaps = toy.gaps();
  // No simulation succeeds any more.
  toy.problem->forward = [](int, int, const Vector&) { return Prediction{}; };
  const Posterior posterior = posterior_of(toy.search, {});
  const ModelFit* pair = posterior.find({0, 1});
  ASSERT_FALSE(gaps.of(*pair).valid);
  EXPECT_FALSE(accepted_posterior(toy.search, gaps, {}).without_form);
  EXPECT_EQ(without_idle_members(posterior, gaps, pair, {}), pair);
}

TEST(Acceptance, FindsSomethingUnknownInASetThatHeldOutDataAskFor) {
  Fitted toy(toy_truth(0.5, 0.01));
  HeldOutGaps gaps = toy.gaps();
  for (ModelFit& m : toy.search.models) m.structure = m.candidates.size() == 2 ? 1e7 : -1e7;
  EXPECT_GT(accepted_posterior(toy.search, gaps, {}).posterior.unexplained, 0.99);
}

TEST(Proposal, IsJudgedByTheModelOfWhatItNames) {
  for (const Vector& truth : {toy_truth(0.5, 0.0), toy_truth(0.5, 0.2), toy_truth(0.0, 0.3)}) {
    const Fitted toy(truth);
    HeldOutGaps gaps = toy.gaps();
    const AcceptedPosterior accepted = accepted_posterior(toy.search, gaps, {});
    const Proposal proposal = propose(accepted.posterior, gaps, {});
    EXPECT_EQ(proposal.naming, Naming::sure);
    std::vector<int> named = proposal.effects;
    std::sort(named.begin(), named.end());
    ASSERT_NE(proposal.chosen, nullptr);
    EXPECT_FALSE(named.empty());
    EXPECT_EQ(proposal.chosen->candidates, named);
  }
}

TEST(Proposal, NamesNothingWhereNoneIsProbable) {
  const Fitted toy(toy_truth(0.0, 0.0));
  HeldOutGaps gaps = toy.gaps();
  const Posterior posterior = posterior_of(toy.search, {});
  const Proposal proposal = propose(posterior, gaps, {});
  EXPECT_EQ(proposal.naming, Naming::nothing);
  EXPECT_TRUE(proposal.chosen->candidates.empty());
}

}  // namespace
}  // namespace jaculus::diagnosis
