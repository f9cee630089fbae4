// A search once more where slopes of tolerances promised what simulating them doesn't keep.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

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

SearchResult searched(int again, std::vector<ModelFit> known = {}) {
  const auto problem = strained_problem();
  problem->settings.searched_again = again;
  NoiseModel noise = estimate_noise(*problem, problem->hypotheses.nominal());
  const Comparison comparison =
      comparison_about(*problem, with_random_effects(*problem, std::move(noise)));
  return select_models(*problem, comparison, {}, std::move(known)).search;
}

Members leading_set(const SearchResult& search) {
  return most_probable(search.models, [](const ModelFit& m) { return m.fit.valid; })->candidates;
}

TEST(SearchedAgain, FindsWhatSlopesOfTolerancesHid) {
  const SearchResult once = searched(0);
  EXPECT_EQ(leading_set(once).size(), 1u);  // the first effect, or its twin
  EXPECT_GT(once.overstated, Settings{}.clear_lead);

  const SearchResult again = searched(Settings{}.searched_again);
  const Members lead = leading_set(again);
  EXPECT_EQ(lead.size(), 2u);
  EXPECT_TRUE(std::binary_search(lead.begin(), lead.end(), 1));
  EXPECT_LT(std::abs(again.overstated), 1.0);
}

TEST(SearchedAgain, HasNoSetTwice) {
  ModelFit known;
  known.candidates = {0, 1};  // which leads too
  known.fit.p = strained_problem()->hypotheses.nominal();
  known.fit.valid = true;
  std::set<Members> sets;
  for (const ModelFit& model : searched(1, {known, known}).models)
    EXPECT_TRUE(sets.insert(model.candidates).second);
}

}  // namespace
}  // namespace jaculus::diagnosis
