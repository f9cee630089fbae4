#include "diagnosis/validation/acceptance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "diagnosis/toy.h"
#include "diagnosis/validation/shares.h"
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
  [[nodiscard]] HeldOutGaps gaps(const Posterior& posterior) const {
    const Fit& none = search.models.front().fit;
    return {*problem, comparison, posterior, none, none};
  }

  std::shared_ptr<Problem> problem;
  Comparison comparison;
  SearchResult search;
};

TEST(Posterior, DoesNotCountAsNoneWhatPromisedMuch) {
  Fitted toy(toy_truth(0.0, 0.0));
  const Posterior fitted = posterior_of(toy.search, {});
  toy.search.probes[3].valid = true;
  toy.search.probes[3].score = 50.0;  // and no fit of it was valid
  const Posterior posterior = posterior_of(toy.search, {});
  EXPECT_EQ(posterior.untold[3], 0.0);
  EXPECT_EQ(posterior.nothing_told(), fitted.nothing_told());
}

TEST(Posterior, LeavesRoomForWhatWasNotWorthAFit) {
  Fitted toy(toy_truth(0.0, 0.0));
  const Posterior fitted = posterior_of(toy.search, {});
  toy.search.probes[3].valid = true;
  toy.search.probes[3].score = -2.0;  // as unlikely by its linear model, and by its prior
  const Posterior posterior = posterior_of(toy.search, {});

  const double odds =
      std::exp(log_prior(1, 4, {}) - log_prior(0, 4, {}) - 2.0);  // of it against none
  EXPECT_NEAR(posterior.untold[3], odds * posterior.none, 1e-12);
  EXPECT_NEAR(posterior.nothing_told(), posterior.none + posterior.untold[3], 1e-12);
  EXPECT_EQ(posterior.untold[0], 0.0);  // fitted
  EXPECT_LT(posterior.none, fitted.none);
  double sum = posterior.nothing_told();
  for (const ModelFit& m : posterior.models)
    sum += m.candidates.empty() ? m.lacking : m.probability();
  EXPECT_NEAR(sum, 1.0, 1e-12);
}

TEST(Acceptance, LeavesOutMembersThatPredictNothing) {
  const Fitted toy(toy_truth(0.5, 0.0)), both(toy_truth(0.5, 0.2));
  for (const auto& [fitted, kept] :
       {std::pair(&toy, std::vector<int>{0}), std::pair(&both, std::vector<int>{0, 1})}) {
    const Posterior posterior = posterior_of(fitted->search, {});
    HeldOutGaps gaps = fitted->gaps(posterior);
    const ModelFit* pair = posterior.find({0, 1});
    EXPECT_EQ(without_idle_members(gaps, *pair).candidates, kept);
  }
}

/// Fitted to two datasets, each with a truth of its own.
Fitted fitted_to_both(const Vector& first, const Vector& second) {
  Fitted toy(first);
  test::ToyData other;
  other.seed = 2;
  toy.problem->observations.datasets.push_back(
      toy_problem(second, other)->observations.datasets[0]);
  toy.comparison = comparison_about(
      *toy.problem,
      with_random_effects(*toy.problem, estimate_noise(*toy.problem, Vector::Zero(4))));
  for (ModelFit& model : toy.search.models)
    model.fit = fit_model(*toy.problem, toy.comparison.whitening, model.candidates,
                          {Vector::Zero(4), Vector::Constant(4, 0.1)});
  return toy;
}

TEST(Acceptance, LeavesOutWhatFitsOneDatasetAndHarmsAnother) {
  for (const double in_second : {0.4, -0.4}) {
    const Fitted toy = fitted_to_both(toy_truth(0.5, 0.4), toy_truth(0.5, in_second));
    const Posterior posterior = posterior_of(toy.search, {});
    HeldOutGaps gaps = toy.gaps(posterior);
    const std::vector<int> kept = without_harmful_members(gaps, *posterior.find({0, 1})).candidates;
    EXPECT_EQ(kept, in_second > 0.0 ? (std::vector<int>{0, 1}) : std::vector<int>{0});
  }
}

TEST(Acceptance, FitsASmallerSetThatTheSearchLeftOut) {
  Fitted toy(toy_truth(0.5, 0.0));
  std::erase_if(toy.search.models, [](const ModelFit& m) { return m.candidates.size() == 1; });
  const Posterior posterior = posterior_of(toy.search, {});
  HeldOutGaps gaps = toy.gaps(posterior);
  const ModelFit kept = without_idle_members(gaps, *posterior.find({0, 1}));
  EXPECT_EQ(kept.candidates, std::vector<int>{0});
  EXPECT_NEAR(kept.fit.p[0] + 2.0 * kept.fit.p[2], 0.5, 0.02);  // a twin stays where it started
}

TEST(Acceptance, DoesNotDependOnWhichSmallerSetsTheSearchFitted) {
  bool stays_by_odds = false;
  for (const double second : {0.0, 1e-4, 2e-4, 3e-4, 3.5e-4, 4e-4, 6e-4}) {
    const Fitted all(toy_truth(0.5, second));
    Fitted fewer(toy_truth(0.5, second));
    std::erase_if(fewer.search.models, [](const ModelFit& m) { return m.candidates.size() == 1; });
    std::vector<std::vector<int>> kept;
    for (const Fitted* toy : {&all, &std::as_const(fewer)}) {
      const Posterior posterior = posterior_of(toy->search, {});
      HeldOutGaps gaps = toy->gaps(posterior);
      const ModelFit* pair = posterior.find({0, 1});
      kept.push_back(without_idle_members(gaps, *pair).candidates);
      const double with = gaps.of(*pair).after, without = gaps.of(gaps.subset(*pair, {0})).after;
      stays_by_odds = stays_by_odds || (kept.back().size() == 2 && with > 0.9 * without);
    }
    EXPECT_EQ(kept[0], kept[1]) << second;
  }
  EXPECT_TRUE(stays_by_odds);
}

TEST(Acceptance, LeavesOutMembersThatExplainNothingOfTheGap) {
  const Fitted toy(toy_truth(0.5, 0.3));
  const Posterior posterior = posterior_of(toy.search, {});
  HeldOutGaps gaps = toy.gaps(posterior);
  const auto kept = [&](const ModelFit& model) {
    return without_members_of_no_share(gaps, model).candidates;
  };
  EXPECT_EQ(kept(*posterior.find({0, 1})), (std::vector<int>{0, 1}));

  ModelFit with_blind = *posterior.find({0, 1});
  with_blind.candidates = {0, 3};
  with_blind.fit = fit_model(*toy.problem, toy.comparison.whitening, {0, 3}, {Vector::Zero(4)});
  EXPECT_EQ(kept(with_blind), std::vector<int>{0});
}

TEST(Acceptance, KeepsWhatExplainsWhatTolerancesLeaveThoughTheGapAsStatedIsManyTimesThat) {
  Fitted toy(toy_truth(0.5, 0.3));
  toy.problem->settings.strong_odds = 1e6;  // so that shares decide
  const Posterior posterior = posterior_of(toy.search, {});
  const ModelFit& pair = *posterior.find({0, 1});
  // As stated the robot is off by what a tolerance takes in full: forty times what effects do.
  const Fit stated = evaluate_model(*toy.problem, toy.comparison.whitening, toy_truth(20.0, 0.0));
  HeldOutGaps gaps(*toy.problem, toy.comparison, posterior, stated, toy.search.models[0].fit);

  for (const auto& share : shares_of(gaps, pair)) {
    ASSERT_TRUE(share.has_value());
    EXPECT_LT(share->shapley, Settings{}.remainder_share);
  }
  EXPECT_EQ(without_members_of_no_share(gaps, pair).candidates, (std::vector<int>{0, 1}));
}

TEST(Acceptance, JudgesNothingByGapsThatAreNotThere) {
  Fitted toy(toy_truth(0.5, 0.01));
  // No simulation succeeds any more.
  toy.problem->forward = [](int, int, const Vector&) { return Prediction{}; };
  const Posterior posterior = posterior_of(toy.search, {});
  HeldOutGaps gaps = toy.gaps(posterior);
  const ModelFit* pair = posterior.find({0, 1});
  ASSERT_FALSE(gaps.of(*pair).valid);
  EXPECT_EQ(without_idle_members(gaps, *pair).candidates, pair->candidates);
}

TEST(Proposal, IsJudgedByTheModelOfWhatItNames) {
  for (const Vector& truth : {toy_truth(0.5, 0.0), toy_truth(0.5, 0.2), toy_truth(0.0, 0.3)}) {
    const Fitted toy(truth);
    const Posterior posterior = posterior_of(toy.search, {});
    HeldOutGaps gaps = toy.gaps(posterior);
    const Proposal proposal = propose(gaps);
    EXPECT_EQ(proposal.naming, Naming::sure);
    std::vector<int> named;
    for (const Established& e : proposal.effects) named.push_back(e.effect);
    std::sort(named.begin(), named.end());
    EXPECT_FALSE(named.empty());
    EXPECT_EQ(proposal.chosen.candidates, named);
  }
}

TEST(Proposal, LeavesToDatasetsThatNoFitSawWhatEvidenceSetsApartUnclearly) {
  const Vector truth = toy_truth(0.5, 0.0);
  const Fitted one(truth), two = fitted_to_both(truth, truth);
  // The first effect predicts best; the second is made to lead it by so many nats.
  const auto chosen = [&](Fitted toy, double lead) {
    std::erase_if(toy.search.models, [](const ModelFit& m) { return m.candidates.size() > 1; });
    ModelFit& second = toy.search.models[2];
    second.log_prior += toy.search.models[1].log_weight() - second.log_weight() + lead;
    const Posterior posterior = posterior_of(toy.search, {});
    HeldOutGaps gaps = toy.gaps(posterior);
    return propose(gaps).chosen.candidates;
  };
  const std::vector<int> first = {0}, other = {1};
  EXPECT_EQ(chosen(two, 9.0), first);
  EXPECT_EQ(chosen(two, 20.0), other);
  EXPECT_EQ(chosen(one, 2.0), first);
  EXPECT_EQ(chosen(one, 9.0), other);
}

/// What is proposed of the first effect and of the twin, which is made to do what it does and more,
/// by the parameter `more`, and to lead it by 0.3 nats at least.
std::vector<int> named_beside_a_wider_one(const Vector& truth, int more) {
  static const effects::Effect wider = [] {
    effects::Effect effect;
    effect.special_case = "first";
    return effect;
  }();
  Fitted toy(truth);
  toy.problem->hypotheses.candidates[2].parameters = {2, more};
  toy.problem->hypotheses.candidates[2].effect = &wider;
  std::erase_if(toy.search.models, [](const ModelFit& m) { return m.candidates.size() > 1; });
  ModelFit& twin = toy.search.models[2];
  twin.candidates = {2};
  twin.fit = fit_model(*toy.problem, toy.comparison.whitening, {2, more}, {Vector::Zero(4)});
  const double lead = toy.search.models[1].log_weight() + 0.3 - twin.log_weight();
  twin.log_prior += std::max(0.0, lead);

  const Posterior posterior = posterior_of(toy.search, {});
  HeldOutGaps gaps = toy.gaps(posterior);
  const Proposal proposal = propose(gaps);
  EXPECT_TRUE(proposal.effects.front().others.empty());
  return proposal.chosen.candidates;
}

TEST(Proposal, NamesTheSimplerEffectWhereNothingTellsWhatTheOtherHasMore) {
  EXPECT_EQ(named_beside_a_wider_one(toy_truth(0.5, 0.0), 1), std::vector<int>{0});
  EXPECT_EQ(named_beside_a_wider_one(toy_truth(0.5, 0.3), 1), std::vector<int>{2});
}

TEST(Proposal, NamesNothingWhereNoneIsProbable) {
  const Fitted toy(toy_truth(0.0, 0.0));
  const Posterior posterior = posterior_of(toy.search, {});
  HeldOutGaps gaps = toy.gaps(posterior);
  const Proposal proposal = propose(gaps);
  EXPECT_EQ(proposal.naming, Naming::nothing);
  EXPECT_TRUE(proposal.chosen.candidates.empty());
}

}  // namespace
}  // namespace jaculus::diagnosis
