// Which pushes and patterns that lead among the models are told, and what is left out.

#include "diagnosis/established_forces.h"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

enum : int { kEffect, kForce, kOtherForce };
constexpr int kTried = 150;

/// An effect and two forces, of patterns, as candidates.
struct ForceCandidates {
  std::vector<effects::Effect> effects{3};
  Problem problem;

  ForceCandidates() {
    const char* names[] = {"friction", "cable", "wave"};
    for (int c = 0; c < 3; ++c) {
      effects[c].pattern = c >= kForce;
      problem.hypotheses.candidates.push_back(
          {names[c], effects::Component::body, {}, &effects[c]});
    }
  }
};

/// None, and models that lead it by so many nats.
SearchResult led(const std::vector<std::pair<std::vector<int>, double>>& models) {
  SearchResult search;
  search.probes.resize(3);
  search.indistinguishable = {{kEffect, kForce}, {kForce, kOtherForce}, {}};
  const auto add = [&](const std::vector<int>& members, double nats) {
    ModelFit model;
    model.candidates = members;
    model.fit.valid = true;
    model.fit.log_evidence = model.fit.log_complete = nats;
    search.models.push_back(model);
  };
  add({}, 0.0);
  for (const auto& [members, nats] : models) add(members, nats);
  return search;
}

double asked(const Settings& settings) { return settings.clear_lead + std::log(kTried); }

TEST(EstablishedForce, LeadsWhatHasNoneByMoreThanHowManyWereTried) {
  const ForceCandidates c;
  const double most = asked(c.problem.settings);
  const auto established = [&](double nats) {
    return force_established(c.problem, led({{{kEffect}, 40.0}, {{kForce}, 40.0 + nats}}), kForce,
                             kTried);
  };
  EXPECT_TRUE(established(most + 0.1));
  EXPECT_FALSE(established(most - 0.1));
}

// What was tried costs that, and not the choice among the catalogue's effects as well.
TEST(EstablishedForce, IsNotChargedAsOneEffectMore) {
  const ForceCandidates c;
  const auto established = [&](double lead) {
    SearchResult search = led({{{kForce}, c.problem.settings.worth + std::log(kTried) + lead}});
    for (ModelFit& model : search.models)
      model.log_prior = log_prior(model.candidates.size(), 3, c.problem.settings);
    search.models[0].fit.log_complete = -1e6;  // a force is missing anyhow
    return force_established(c.problem, search, kForce, kTried);
  };
  EXPECT_TRUE(established(0.1));
  EXPECT_FALSE(established(-0.1));
}

TEST(EstablishedForce, MayBeOfAnotherForm) {
  const ForceCandidates c;
  EXPECT_TRUE(
      force_established(c.problem, led({{{kOtherForce}, 59.0}, {{kForce}, 60.0}}), kForce, kTried));
}

// Each of two must be needed: one may not ride on the other.
TEST(EstablishedForce, IsAskedBesideAnother) {
  const ForceCandidates c;
  const SearchResult search =
      led({{{kEffect, kOtherForce}, 59.0}, {{kForce, kOtherForce}, 60.0}, {{kEffect}, 5.0}});
  EXPECT_FALSE(force_established(c.problem, search, kForce, kTried));
  EXPECT_TRUE(force_established(c.problem, search, kOtherForce, kTried));
}

// Where what is without it leaves more, a force is missing anyhow.
TEST(EstablishedForce, NeedsAClearLeadOnlyInThePlaceOfWhatLeavesNothing) {
  const ForceCandidates c;
  const double lead = c.problem.settings.worth + std::log(kTried) + 0.1;
  SearchResult search = led({{{kEffect}, 40.0}, {{kForce}, 40.0 + lead}});
  EXPECT_FALSE(force_established(c.problem, search, kForce, kTried));
  search.models[1].fit.log_complete = -1e6;
  EXPECT_TRUE(force_established(c.problem, search, kForce, kTried));
}

// Between a push and a pattern that are both needed the more probable one is told.
TEST(EstablishedForce, IsNotAskedToLeadOneOfAnotherKind) {
  ForceCandidates c;
  c.effects[kOtherForce].pattern = false;
  c.effects[kOtherForce].event = true;
  const SearchResult search = led({{{kEffect}, 5.0}, {{kForce}, 58.0}, {{kOtherForce}, 60.0}});
  EXPECT_TRUE(force_established(c.problem, search, kOtherForce, kTried));
}

TEST(LeaveOut, WhatDoesNotHoldIsNoCandidateAnyMore) {
  const ForceCandidates c;
  Selection found;
  found.search = led({{{kEffect}, 55.0}, {{kForce}, 60.0}, {{kOtherForce}, 30.0}});
  leave_out_unfounded(c.problem, kTried, found);
  EXPECT_EQ(leading(found.search).candidates, std::vector<int>{kEffect});
  EXPECT_EQ(found.search.models.size(), 2U);
  EXPECT_EQ(found.search.indistinguishable[kEffect], std::vector<int>{kEffect});
  EXPECT_FALSE(found.search.probes[kForce].valid);

  found.search = led({{{kEffect}, 20.0}, {{kForce}, 60.0}, {{kOtherForce}, 30.0}});
  leave_out_unfounded(c.problem, kTried, found);
  EXPECT_EQ(leading(found.search).candidates, std::vector<int>{kForce});
  EXPECT_EQ(found.search.models.size(), 3U);  // the other force, which doesn't lead, is left out
}

// Neither is needed beside the other: the more probable one is told, not the other one.
TEST(LeaveOut, OfTwoThatExplainTheSameTheMoreProbableStays) {
  const ForceCandidates c;
  Selection found;
  found.search = led({{{kOtherForce}, 49.0}, {{kForce}, 50.0}, {{kForce, kOtherForce}, 52.0}});
  leave_out_unfounded(c.problem, kTried, found);
  EXPECT_EQ(leading(found.search).candidates, std::vector<int>{kForce});
}

/// Data of one toy effect, fitted by it and by another that is called a push; the push leads by so
/// many nats, whatever its fit.
struct WithPush {
  std::shared_ptr<Problem> problem;
  effects::Effect effect, push;
  Selection found;

  WithPush(const Vector& truth, double lead) : problem(test::toy_problem(truth)) {
    push.event = true;
    problem->hypotheses.candidates[0].effect = &effect;
    problem->hypotheses.candidates[1].effect = &push;
    found.comparison =
        comparison_about(*problem, estimate_noise(*problem, problem->hypotheses.nominal()));
    found.search.probes.resize(4);
    found.search.indistinguishable.resize(4);
    const double nats[] = {0.0, 40.0, 40.0 + lead};
    for (const std::vector<int>& members : {std::vector<int>{}, {0}, {1}}) {
      ModelFit model;
      model.candidates = members;
      model.fit = fit_model(*problem, found.comparison.whitening, members,
                            {Vector::Zero(4), Vector::Constant(4, 0.1)});
      model.fit.log_evidence = model.fit.log_complete = nats[found.search.models.size()];
      found.search.models.push_back(model);
    }
  }
};

/// The same without the push.
Selection without_push(Selection found) {
  std::erase_if(found.search.models,
                [](const ModelFit& model) { return model.candidates == std::vector<int>{1}; });
  return found;
}

TEST(PredictsAsWell, IsAskedOfEveryLeadHoweverClear) {
  const Vector by_effect = test::toy_truth(0.5, 0.0), by_push = test::toy_truth(0.0, 0.3);
  const auto well = [](const Vector& truth, double lead) {
    const WithPush own(truth, lead);
    const Selection alone = without_push(own.found);
    return predicts_as_well({*own.problem, own.found}, {*own.problem, alone});
  };
  const double clear = Settings{}.clear_lead;
  EXPECT_FALSE(well(by_effect, clear - 1.0));
  EXPECT_FALSE(well(by_effect, clear + 1.0));
  EXPECT_TRUE(well(by_push, clear - 1.0));
}

}  // namespace
}  // namespace jaculus::diagnosis
