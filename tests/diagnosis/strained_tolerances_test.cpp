// A search beside tolerances that can do what effects do, and beside models known from another.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/selection/fitted_models.h"
#include "diagnosis/selection/neighbouring_sets.h"
#include "diagnosis/selection/search.h"
#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kShape = 4;              // index of the tolerance
constexpr double kBothEffects = 12.0;  // deviations at which it does what both effects do
constexpr double kFirstTrue = 0.12, kSecondTrue = 1.67e-3;

/// The robot without effects strains its tolerance to do what they do. There the slope of the
/// second effect's part is zero: by slopes that part stays however far the tolerance goes back, so
/// that the first effect alone seems to leave nothing.
std::shared_ptr<Problem> strained_problem() {
  auto problem = test::toy_problem(test::toy_truth(kFirstTrue, kSecondTrue));
  problem->hypotheses.parameters.push_back(
      {"tolerance", "shape", "deviations", 0.0, 1.0, {-15.0, 15.0}});
  problem->hypotheses.tolerances = {kShape};
  problem->forward = [](int, int, const Vector& p) {
    const double share = p[kShape] / kBothEffects;
    Vector all = p.head(4);
    all[0] += kFirstTrue * share;
    all[1] += kSecondTrue * (1.0 - std::pow(1.0 - share, 2));
    return test::toy_prediction(all);
  };
  return problem;
}

Comparison nominal_comparison(const Problem& problem) {
  NoiseModel noise = estimate_noise(problem, problem.hypotheses.nominal());
  return comparison_about(problem, with_random_effects(problem, std::move(noise)));
}

SearchResult searched(std::vector<ModelFit> known = {}) {
  const auto problem = strained_problem();
  return select_models(*problem, nominal_comparison(*problem), {}, std::move(known)).search;
}

Members leading_set(const SearchResult& search) {
  return most_probable(search.models, [](const ModelFit& m) { return m.fit.valid; })->candidates;
}

/// About the robot without effects, which leaves least, the search would end with the first.
TEST(StrainedTolerances, AreAPriceAndNoPlaceToGoOnFrom) {
  const Members lead = leading_set(searched());
  EXPECT_EQ(lead.size(), 2u);
  EXPECT_TRUE(std::binary_search(lead.begin(), lead.end(), 1));
}

ModelFit known_model(const Members& members) {
  ModelFit known;
  known.candidates = members;
  known.fit.p = strained_problem()->hypotheses.nominal();
  known.fit.valid = true;
  return known;
}

TEST(KnownModels, AreFittedOnce) {
  const ModelFit known = known_model({0, 1});  // which leads too
  std::set<Members> sets;
  for (const ModelFit& model : searched({known, known}).models)
    EXPECT_TRUE(sets.insert(model.candidates).second);
}

/// Another search of these data had the sets of effects, and what led there is known.
TEST(KnownModels, LeaveNoOtherSetOfEffectsToSeek) {
  const auto sets = [](const SearchResult& search) {
    std::set<Members> found;
    for (const ModelFit& model : search.models)
      if (model.candidates.size() > 1) found.insert(model.candidates);
    return found;
  };
  EXPECT_GT(sets(searched()).size(), 1u);
  const ModelFit known = known_model({0, 2});
  EXPECT_EQ(sets(searched({known})), std::set<Members>{known.candidates});
}

/// A push stands by what it gains over the effects beside it, however these were left out before.
TEST(KnownModels, OfEffectsAreFittedWhereASetHasThemWithAForce) {
  const auto problem = strained_problem();
  effects::Effect push;
  push.event = true;
  problem->hypotheses.candidates[2].effect = &push;
  const Comparison comparison = nominal_comparison(*problem);
  FittedModels models(*problem, comparison, nullptr, false);
  models.seek_beyond_effects();
  models.fit_again({known_model({0, 1, 2})});
  EXPECT_EQ(models.find({0, 1}), nullptr);
  models.fit_without_forces();
  ASSERT_NE(models.find({0, 1}), nullptr);
  EXPECT_TRUE(models.find({0, 1})->fit.valid);
}

}  // namespace
}  // namespace jaculus::diagnosis
